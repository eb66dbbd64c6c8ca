"""Count wordy patterns in the README, the guides and the help pages. Exit with code 1 if the text as a whole is out of bounds.

Usage: python plain_english.py [ROOT] (the repository, default `.`)

Figures are per 1000 words. Code blocks and inline code are not counted.
"""

import pathlib
import re
import sys

# Each pattern with its bound: at most, or at least.
AT_MOST = {"what": 0.5, "those of": 0.2, "says": 0.7, "beside": 0.3}
AT_LEAST = {"you": 12.0}
PATTERNS = {
    "those of": re.compile(r"\b(?:those|that) of\b"),
    "says": re.compile(r"\b(?:says?|tells?)\b"),
    "beside": re.compile(r"\bbeside\b"),
    "you": re.compile(r"\byou(?:rs?|rself)?\b"),
}


def paragraphs(text):
    """Yield paragraphs, list items and table cells as one lower-case line each, without code."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"``.+?``|`[^`]*`", " X ", text)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    lines = []
    for line in text.splitlines() + [""]:
        indented = line.startswith("    ") and not lines
        starts = re.match(r"\s*(?:[-*#|]|\d+\. )", line)
        if (starts or not line.strip()) and lines:
            yield " ".join(lines)
            lines = []
        if line.lstrip().startswith("|"):
            yield from (cell.strip().lower() for cell in line.split("|"))
        elif line.strip() and not indented:
            lines.append(line.strip().lower())


def count(text):
    """Return the number of words and of each pattern in a text."""
    counts = dict.fromkeys([*AT_MOST, *AT_LEAST, "words"], 0)
    for paragraph in paragraphs(text):
        counts["words"] += len(re.findall(r"[a-z][\w'-]*", paragraph))
        for name, pattern in PATTERNS.items():
            counts[name] += len(pattern.findall(paragraph))
        # "what" in a question is plain; anywhere else it stands for a noun.
        for sentence in re.split(r"(?<=[.?!:;])\s", paragraph):
            if not sentence.endswith("?"):
                counts["what"] += len(re.findall(r"\bwhat\b", sentence))
    return counts


def report(name, counts):
    """Print one line: file, words, figures per 1000 words."""
    figures = (f"{1000.0 * counts[key] / max(counts['words'], 1):9.2f}" for key in (*AT_MOST, *AT_LEAST))
    print(f"{name:34}{counts['words']:7}" + "".join(figures))


def main(root):
    """Print the figures per file and overall, and return the bounds that do not hold."""
    print(f"{'per 1000 words':34}{'words':>7}" + "".join(f"{key:>9}" for key in (*AT_MOST, *AT_LEAST)))
    total = dict.fromkeys([*AT_MOST, *AT_LEAST, "words"], 0)
    for file in [root / "README.md", *sorted(root.glob("studies/guide/*.md")), *sorted(root.glob("src/guide/*.md"))]:
        counts = count(file.read_text(encoding="utf-8"))
        total = {key: total[key] + counts[key] for key in total}
        report(str(file.relative_to(root)), counts)
    report("all", total)
    rate = {key: 1000.0 * total[key] / total["words"] for key in total}
    wrong = [f"`{key}` {rate[key]:.2f}, at most {bound}" for key, bound in AT_MOST.items() if rate[key] > bound]
    return wrong + [f"`{key}` {rate[key]:.2f}, at least {bound}" for key, bound in AT_LEAST.items() if rate[key] < bound]


if __name__ == "__main__":
    if failed := main(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")):
        sys.exit("plain_english: out of bounds per 1000 words: " + "; ".join(failed) + "; see the rules in CONTRIBUTING.md")
