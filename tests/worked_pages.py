"""Follow the worked pages command by command, and compare the output with the page.

Usage: python worked_pages.py STUDIES PROGRAM [PAGE ...] (the folder `studies`; the built program; default: all pages)
With DECORE_UPDATE_PAGES=1 lines that differ are replaced by the most similar lines of the output.

A page's `console` blocks hold commands (`$ decore ...`) and their output, in which `...` matches anything. Commands run without a shell, so that
they work in every shell. A comment behind a command states its exit code (`# exit code 4`), or asks for an interruption
(`# press Ctrl-C after 3 seconds`). A `toml` block begins with a comment with the name of its file. A `python` block runs in this
interpreter; a `text` block behind it is its output.
"""

import difflib
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile


def blocks(page):
    """Yield the fenced blocks of a page: language, text, line."""
    language, lines, start = None, [], 0
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if language is None and line.startswith("```"):
            language, lines, start = line[3:].strip(), [], number
        elif line == "```":
            yield language, lines, start
            language = None
        elif language is not None:
            lines.append(line)
    if language is not None:
        sys.exit(f"{page}:{start}: the block does not end")


def commands(lines):
    """Return the commands of a block with the expected lines of each."""
    found = []
    for line in lines:
        if line.startswith("$ "):
            found.append((line[2:], []))
        elif found:
            found[-1][1].append(line)
    return found


def shows(expected, printed):
    """Return whether a text matches; `...` matches anything, over several lines if it is alone on its line."""
    pattern = "\n".join(expected).strip()
    pattern = re.escape(pattern).replace(r"\.\.\.", ".*?")
    return re.fullmatch(pattern, printed.strip(), re.DOTALL) is not None


def updated(expected, printed):
    """Return the expected lines, each that is not in the output replaced by the most similar line of the output."""
    rest, found = printed.strip().splitlines(), []
    for line in expected:
        match = next((place for place, one in enumerate(rest) if shows([line], one)), None)
        if line.strip() != "..." and match is None and rest:
            likeness = [difflib.SequenceMatcher(None, line, one).ratio() for one in rest]
            match = likeness.index(max(likeness))
            line = rest[match]
        found.append(line)
        rest = rest if line.strip() == "..." or match is None else rest[match + 1 :]
    return found


def hold(page, number, expected, printed, program):
    """End the program unless the output matches the page; with DECORE_UPDATE_PAGES=1 change the page instead."""
    if shows(expected, printed):
        return
    new = updated(expected, printed)
    if os.environ.get("DECORE_UPDATE_PAGES") != "1" or not shows(new, printed):
        difference = "\n".join(difflib.unified_diff(expected, printed.splitlines(), "page", "output", lineterm=""))
        sys.exit(f"{page}:{number}: the output of {program} differs from the page\n{difference}")
    page.write_text(page.read_text().replace("\n".join(expected), "\n".join(new), 1))


def run(command, folder):
    """Return the output of a command without a shell; end the program if its exit code is not the expected one."""
    words = shlex.split(command, comments=True)
    if words[0] not in ("decore", "python"):
        sys.exit(f"worked_pages: `{command}`: pages use only `decore` and `python`, which every shell has")
    comment = command.partition(" # ")[2]
    code = int((re.search(r"exit code (\d+)", comment) or [0, 0])[1])
    words[0] = sys.executable if words[0] == "python" else words[0]
    with subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        if pause := re.search(r"Ctrl-C after (\d+) seconds", comment):
            try:
                process.wait(float(pause[1]))
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
        output, errors = process.communicate()
    if process.returncode != code:
        sys.exit(f"worked_pages: {command}: exit code {process.returncode}, expected {code}\n{output}\n{errors}")
    return "\n".join(line.rstrip() for line in output.splitlines())


def follow(page, folder):
    """Follow a page in a folder."""
    output = ""
    for language, lines, number in blocks(page):
        if language == "toml":
            name = lines[0].removeprefix("# ")
            (folder / name).write_text("\n".join(lines) + "\n")
        elif language == "python":
            (folder / "block.py").write_text("\n".join(lines) + "\n")
            output = run("python block.py", folder)
            print(output)
        elif language == "text":
            hold(page, number, lines, output, "the program above")
        elif language == "console":
            for command, expected in commands(lines):
                printed = run(command, folder)
                print(f"$ {command}\n{printed}")
                if expected:
                    hold(page, number, expected, printed, f"`{command}`")
        else:
            sys.exit(f"{page}:{number}: unknown language `{language}` of a block")


def main(studies, program, names):
    """Follow all pages; the first one that differs ends the program."""
    os.environ["PATH"] = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    pages = [studies / "guide" / name for name in names] or sorted((studies / "guide").glob("*.md"))
    if not pages:
        sys.exit("worked_pages: there are no pages")
    for page in pages:
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            shutil.copytree(studies, folder / "studies")
            follow(page, folder)
        print(f"worked_pages: {page.name} holds")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3:])
