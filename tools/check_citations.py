#!/usr/bin/env python3
"""Checks that every [Key] in a comment and every source = "KEY" in a TOML file stands in docs/references.md, and that
every key there is used.

A citation is a bracket that begins with a capital letter and has three or more letters, digits or dashes, in a comment:
[Schlick94], [McAuley12 s.14], [UNI, FXA]. Array indices follow a name and are no citations."""

import re

import source_tree

REFERENCES = "docs/references.md"
KEY = r"[A-Z][A-Za-z0-9-]{2,}"
LISTED_KEY = r"[A-Za-z][A-Za-z0-9-]{2,}"  # a listed key may begin in lower case (glTF2): it is found once it is listed
BRACKET = re.compile(r"(?<![\w\])`])\[(" + LISTED_KEY + r"(?=[\],; ])[^\]\n]*)\](?![(\[])")
ENTRY = re.compile(r"^- \[(" + LISTED_KEY + r")\] \S", re.MULTILINE)
TOML_SOURCE = re.compile(r'^[^#\n]*?\bsource\s*=\s*"([^"\n]*)"', re.MULTILINE)
HASH_COMMENT = re.compile(r"(?:^|\s)#([^\n]*)")
CODE_SPAN = re.compile(r"```.*?```|`[^`\n]*`", re.DOTALL)

C_LIKE = source_tree.CODE_SUFFIXES
HASH_LIKE = {".py", ".cmake", ".toml"}


def keys_in(bracket, known):
    """The keys of one bracket: 'UNI, FXA' has two, 'McAuley12 s.14' one and a locator."""
    firsts = [re.match(LISTED_KEY + r"(?![\w-])", part.strip()) for part in re.split(r"[,;]", bracket)]
    words = [first.group(0) for first in firsts if first]
    return [word for word in words if word in known or re.fullmatch(KEY, word)]


def comments_of(name, text):
    suffix = "." + name.rsplit(".", 1)[-1]
    if suffix in C_LIKE:
        return source_tree.comments_only(text)
    if suffix in HASH_LIKE:
        return "\n".join(" ".join(HASH_COMMENT.findall(line)) for line in text.split("\n"))
    if suffix == ".md":
        return CODE_SPAN.sub(lambda span: re.sub(r"[^\n]", " ", span.group(0)), text)
    return ""


def citations(name, text, known):
    """(line, key) of everything a file cites."""
    found = []
    comments = comments_of(name, text)
    for match in BRACKET.finditer(comments):
        found += [(source_tree.line_of(comments, match.start()), key) for key in keys_in(match.group(1), known)]
    if name.endswith(".toml"):
        for match in TOML_SOURCE.finditer(text):
            found += [(source_tree.line_of(text, match.start()), key) for key in keys_in(match.group(1), known)]
    return found


def check(root):
    problems = []
    listing = root / REFERENCES
    entries = ENTRY.findall(source_tree.text_of(listing) or "") if listing.is_file() else []
    if not entries:
        problems.append(f"{REFERENCES}: expected lines '- [Key] reference', found none")
    problems += [f"{REFERENCES}: [{key}] is listed twice" for key in sorted({k for k in entries if entries.count(k) > 1})]
    if entries != sorted(entries, key=str.lower):
        problems.append(f"{REFERENCES}: the keys are not in alphabetical order")
    known, used = set(entries), {}
    for name, path in source_tree.files(root):
        # The tests of this check plant keys that exist nowhere.
        if name == REFERENCES or name.startswith(("tests/house/", "tools/")):
            continue
        text = source_tree.text_of(path)
        for line, key in citations(name, text, known) if text else []:
            used.setdefault(key, []).append(f"{name}:{line}")
    for key in sorted(set(used) - known):
        places = used[key]
        more = f" and {len(places) - 1} more" if len(places) > 1 else ""
        problems.append(f"{places[0]}{more}: [{key}] is not in {REFERENCES}")
    problems += [f"{REFERENCES}: [{key}] is cited nowhere" for key in sorted(known - set(used))]
    return problems


if __name__ == "__main__":
    source_tree.report("check_citations", check(source_tree.parse_root(__doc__)))
