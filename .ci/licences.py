"""Copies the licence files of all crates in the program into a folder: `licences.py FOLDER`."""

import json
import pathlib
import shutil
import subprocess
import sys

NAMES = ("LICEN", "COPYING", "NOTICE", "UNLICENSE")
TARGETS = ("x86_64-unknown-linux-gnu", "x86_64-pc-windows-gnu")


def crates(target: str) -> dict[str, dict]:
    """Packages that the program is built from for a target, by id; development and build dependencies left out."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    told = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    packages = {package["id"]: package for package in told["packages"]}
    nodes = {node["id"]: node for node in told["resolve"]["nodes"]}
    root = next(package["id"] for package in told["packages"] if package["name"] == "decore")
    found, ahead = {}, [root]
    while ahead:
        crate = ahead.pop()
        if crate in found:
            continue
        found[crate] = packages[crate]
        for dependency in nodes[crate]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                ahead.append(dependency["pkg"])
    return found


def main(folder: pathlib.Path) -> None:
    folder.mkdir(parents=True)
    found = {crate: package for target in TARGETS for crate, package in crates(target).items()}
    foreign = sorted((package for package in found.values() if package["source"]), key=lambda package: package["name"])
    lines, without = [], []
    for package in foreign:
        name = f"{package['name']}-{package['version']}"
        lines.append(f"{name}: {package['license'] or 'see its licence file'}, {package['repository'] or 'no repository named'}")
        source = pathlib.Path(package["manifest_path"]).parent
        files = [file for file in source.iterdir() if file.is_file() and file.name.upper().startswith(NAMES)]
        if not files:
            without.append(name)
        for file in files:
            to = folder / name / file.name
            to.parent.mkdir(exist_ok=True)
            shutil.copyfile(file, to)
    if without:
        lines += ["", "These crates contain no licence file; their licences are named above:", ", ".join(without)]
    (folder / "README.txt").write_text("\n".join(["decore contains these crates:", "", *lines, ""]), encoding="utf-8")
    print(f"licences of {len(foreign)} crates, {len(without)} without a file")


main(pathlib.Path(sys.argv[1]))
