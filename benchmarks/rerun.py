"""What does a rerun cost that has nothing to do, and what does a first run cost beside the work?

Twelve stages in a chain, each writing one file of 1 MB from the one before, as tendril, as `dvc
repro` and as `snakemake` (those two where they are installed: on the PATH or in the folder that
TENDRIL_BENCH_BIN names). The limit of a rerun is the start of Python and one look at each file.

    python -m benchmarks.rerun [--repeats 7]
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STAGES = 12
NODE = '''
def step_{n:02d}(part_{before:02d}: dict) -> dict:
    """Add one and pass on."""
    return {{"value": part_{before:02d}["value"] + 1, "bulk": part_{before:02d}["bulk"]}}
'''
SCRIPT = """import json, sys
source, target = sys.argv[1:]
with open(source) as stream:
    part = json.load(stream)
part["value"] += 1
with open(target, "w") as stream:
    json.dump(part, stream)
"""
START = json.dumps({"value": 0, "bulk": "x" * 1_000_000})


def make_tendril(folder: Path) -> None:
    """Lay out the chain as a tendril project."""
    for name in ("nodes", "catalog", "pipelines"):
        ignore = shutil.ignore_patterns("__pycache__", "cases", "parameters")
        shutil.copytree(ROOT / name, folder / name, ignore=ignore)
    chain = [(n, n - 1) for n in range(1, STAGES + 1)]
    files = {f"nodes/chain/step_{n:02d}.py": NODE.format(n=n, before=b) for n, b in chain}
    stages = "".join(
        f'    Stage("chain.step_{n:02d}", ["part_{b:02d}"], ["part_{n:02d}"]),\n' for n, b in chain
    )
    parts = "".join(f"part_{n:02d}: {{about: a part, format: record}}\n" for n, _ in chain)
    files |= {
        "nodes/chain/__init__.py": "",
        "pipelines/chain.py": f"from pipelines.stage import Stage\n\nSTAGES = [\n{stages}]\n",
        "pipelines/registry.py": 'from pipelines import chain\n\nPIPELINES = {"chain": chain}\n',
        "catalog/catalog.yml": "part_00: {about: start, format: record, place: input}\n" + parts,
        "catalog/cases/one.yml": "title: One\npipeline: chain\ninputs: {part_00: record.json}\n",
        "data/raw/record.json": START,
    }
    write_files(folder, files)


def make_dvc(folder: Path) -> None:
    """Lay out the chain as a DVC pipeline."""
    stages = {
        f"step{n:02d}": {
            "cmd": f"{sys.executable} step.py {n - 1:02d}.json {n:02d}.json",
            "deps": ["step.py", f"{n - 1:02d}.json"],
            "outs": [f"{n:02d}.json"],
        }
        for n in range(1, STAGES + 1)
    }
    files = {"step.py": SCRIPT, "00.json": START, "dvc.yaml": json.dumps({"stages": stages})}
    write_files(folder, files)
    dvc = find("dvc")
    call([dvc, "init", "--no-scm", "--quiet"], folder)
    call([dvc, "config", "core.analytics", "false"], folder)


def make_snakemake(folder: Path) -> None:
    """Lay out the chain as a Snakemake workflow."""
    rules = [f'rule all:\n    input: "{STAGES:02d}.json"\n']
    rules += [
        f'rule step{n:02d}:\n    input: "step.py", "{n - 1:02d}.json"\n'
        f'    output: "{n:02d}.json"\n'
        f'    shell: "{sys.executable} {{input[0]}} {{input[1]}} {{output}}"\n'
        for n in range(1, STAGES + 1)
    ]
    write_files(folder, {"step.py": SCRIPT, "00.json": START, "Snakefile": "\n".join(rules)})


def write_files(folder: Path, files: dict[str, str]) -> None:
    """Write texts below a folder."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def find(program: str) -> str:
    """Return the path of a peer, "" where it is not installed."""
    folders = os.pathsep.join([os.environ.get("TENDRIL_BENCH_BIN", ""), os.environ["PATH"]])
    return shutil.which(program, path=folders) or ""


def call(words: Sequence[str], folder: Path) -> float:
    """Run a command to its end and return its wall time in s."""
    started = time.perf_counter()
    quiet = {**os.environ, "DO_NOT_TRACK": "1", "DVC_NO_ANALYTICS": "1"}
    done = subprocess.run(words, cwd=folder, env=quiet, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(words)} failed:\n{done.stdout}{done.stderr}")
    return time.perf_counter() - started


def bare_functions(folder: Path) -> float:
    """Return the wall time in s of the twelve functions called by hand, files and all."""
    source = f"""
import importlib, json, pathlib
part = json.loads(pathlib.Path("data/raw/record.json").read_text())
for n in range(1, {STAGES} + 1):
    function = getattr(importlib.import_module(f"nodes.chain.step_{{n:02d}}"), f"step_{{n:02d}}")
    part = function(part)
    pathlib.Path(f"bare{{n:02d}}.json").write_text(json.dumps(part))
"""
    return call([sys.executable, "-c", source], folder)


def measure(tools: dict[str, tuple[list[str], Path]], repeats: int) -> dict[str, float]:
    """Return the median wall time in s of each tool, taken in turns."""
    times: dict[str, list[float]] = {name: [] for name in tools}
    for _ in range(repeats):
        for name, (words, folder) in tools.items():
            times[name].append(call(words, folder))
    return {name: statistics.median(values) for name, values in times.items()}


def main() -> None:
    """Measure, print the table, and last the JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=7)
    repeats = parser.parse_args().repeats
    with tempfile.TemporaryDirectory() as scratch:
        result = run_all(Path(scratch), repeats)
    print(f"\n{STAGES} stages in a chain, 1 MB each; medians of {repeats}, wall time in s")
    for name, value in result.items():
        shown = "not installed" if value is None else f"{value:8.3f}"
        print(f"  {name:44} {shown}")
    print(json.dumps(result))


def run_all(scratch: Path, repeats: int) -> dict[str, float | None]:
    """Lay out all peers, take first runs and reruns."""
    tendril = [sys.executable, "-m", "pipelines.cli", "run"]
    makers: dict[str, tuple[Callable[[Path], None], list[str]]] = {
        "tendril": (make_tendril, tendril),
        "dvc": (make_dvc, [find("dvc"), "repro", "--quiet"]),
        "snakemake": (make_snakemake, [find("snakemake"), "--cores", "1", "--quiet"]),
    }
    first: dict[str, float] = {}
    tools: dict[str, tuple[list[str], Path]] = {}
    for name, (make, words) in makers.items():
        if words[0]:
            (scratch / name).mkdir()
            make(scratch / name)
            first[name] = call(words, scratch / name)
            tools[name] = (words, scratch / name)
    time.sleep(1.5)  # files that are younger than a tick of the clock are looked at twice
    rerun = measure(tools, repeats)
    started = statistics.median(call([sys.executable, "-c", ""], scratch) for _ in range(repeats))
    return {
        "rerun, nothing stale: start of Python alone": started,
        **{f"rerun, nothing stale: {name}": rerun.get(name) for name in makers},
        **{f"first run: {name}": first.get(name) for name in makers},
        **first_runs_of_tendril(scratch, repeats),
    }


def first_runs_of_tendril(scratch: Path, repeats: int) -> dict[str, float]:
    """Return medians of first runs with and without Prefect, and of the bare functions."""
    times: dict[str, list[float]] = {"bare": [], "plain": [], "prefect": []}
    folder = scratch / "tendril"
    for _ in range(repeats):
        times["bare"].append(bare_functions(folder))
        for name, more in {"plain": ["--no-prefect"], "prefect": []}.items():
            shutil.rmtree(folder / "data" / "store")
            times[name].append(call([sys.executable, "-m", "pipelines.cli", "run", *more], folder))
    bare, plain, prefect = (statistics.median(times[name]) for name in times)
    return {
        "first run: the bare functions and files": bare,
        "first run: tendril --no-prefect, database there": plain,
        "first run: tendril, database there": prefect,
        "overhead over the bare functions, --no-prefect": plain - bare,
        "overhead over the bare functions, with Prefect": prefect - bare,
    }


if __name__ == "__main__":
    main()
