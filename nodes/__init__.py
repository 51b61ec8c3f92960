"""The science: pure functions, one folder a stage; no files, no Prefect, no YAML."""
