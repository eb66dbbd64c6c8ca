"""Does what the worked pages say, command by command, and holds what they show to what is printed.

Usage: python worked_pages.py STUDIES PROGRAM [PAGE ...] (the folder `studies`; the built program; pages of it, all unless named)
With DECORE_UPDATE_PAGES=1 lines that are no longer printed are replaced by those that are, where their number is the same.

A page's `console` blocks hold commands (`$ ...`) and what they print, in which `...` stands for anything; its `toml` blocks begin with a
comment that names the file to write; its `python` blocks are run by this interpreter, a `text` block behind one is what it prints.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile


def blocks(page):
    """The fenced blocks of a page: language, text, line."""
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
    """The commands of a block with the lines that each is to print."""
    found = []
    for line in lines:
        if line.startswith("$ "):
            found.append((line[2:], []))
        elif found and found[-1][0].endswith("\\"):
            found[-1] = (f"{found[-1][0]}\n{line}", [])
        elif found:
            found[-1][1].append(line)
    return found


def shows(expected, printed):
    """Whether a text is as shown; `...` stands for anything, over lines where it stands alone."""
    pattern = "\n".join(expected).strip()
    pattern = re.escape(pattern).replace(r"\.\.\.", ".*?")
    return re.fullmatch(pattern, printed.strip(), re.DOTALL) is not None


def hold(page, number, expected, printed, what):
    """Ends the program unless what is printed is as shown; the page is brought up to date instead where that is asked for."""
    if shows(expected, printed):
        return
    new = printed.strip().splitlines()
    if os.environ.get("DECORE_UPDATE_PAGES") != "1" or len(new) != len(expected):
        sys.exit(f"{page}:{number}: {what} does not print what the page shows")
    text = page.read_text()
    lines = [old if shows([old], line) else line for old, line in zip(expected, new)]
    page.write_text(text.replace("\n".join(expected), "\n".join(lines), 1))


def run(command, folder):
    """What a command prints; the program ends if it fails."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"worked_pages: {command}: code {done.returncode}\n{done.stdout}\n{done.stderr}")
    return "\n".join(line.rstrip() for line in done.stdout.splitlines())


def follow(page, folder):
    """Does what a page says in a folder."""
    said = ""
    for language, lines, number in blocks(page):
        if language == "toml":
            name = lines[0].removeprefix("# ")
            (folder / name).write_text("\n".join(lines) + "\n")
        elif language == "python":
            said = run([sys.executable, "-c", "\n".join(lines)], folder)
            print(said)
        elif language == "text":
            hold(page, number, lines, said, "the program above")
        elif language == "console":
            for command, expected in commands(lines):
                printed = run(["bash", "-euo", "pipefail", "-c", command], folder)
                print(f"$ {command}\n{printed}")
                if expected:
                    hold(page, number, expected, printed, f"`{command}`")
        else:
            sys.exit(f"{page}:{number}: a block of `{language}`")


def main(studies, program, names):
    """All pages; the first that is wrong ends the program."""
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
