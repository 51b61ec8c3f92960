# make run    sets everything up and runs every case whose inputs are on this machine
# make test   sets everything up and passes the tests
VENV ?= .venv
BIN = $(VENV)/bin

.PHONY: run test lint bench serve setup setup-test
run: setup
	@$(BIN)/tendril run

test: setup-test lint
	$(BIN)/python -m pytest -n 2 --dist loadgroup

lint: setup-test
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/lint-imports

bench: setup
	$(BIN)/python -m benchmarks.rerun
	$(BIN)/python -m benchmarks.imaging
	$(BIN)/python -m benchmarks.mechanics
	$(BIN)/python -m benchmarks.crisp_planning

serve: setup
	$(BIN)/tendril serve

setup:
	@./setup.sh $(VENV) "$$(test -e '$(VENV)/ready[test]' && echo '[test]')"

setup-test:
	@./setup.sh $(VENV) "[test]"
