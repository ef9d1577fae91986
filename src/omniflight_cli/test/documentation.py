"""What the tests of the documentation share: pages, their commands, and the options of every verb as --help tells them."""

import re
import shlex

import system

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
SPAN = re.compile(r"`([^`\n]+)`")
# a heading's anchor as GitHub and the site make it
HEADING = re.compile(r"^#+ +(.+?) *$", re.M)


def pages():
    """Every Markdown page of the repository."""
    return sorted(page for pattern in ("*.md", "docs/**/*.md", "src/**/*.md") for page in system.ROOT.glob(pattern))


def commands_hold_in(page):
    """Not in the diaries (results, decisions, changelog), which tell what was."""
    name = str(page.relative_to(system.ROOT))
    return not name.startswith(("docs/results/", "docs/adr/", "CHANGELOG"))


def anchors(text):
    """Anchors of the headings of a page."""
    found = set()
    for title in HEADING.findall(BLOCK.sub("", text)):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).lower()
        found.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


def lines_of(text):
    """Commands of the ```bash blocks of a page, one a line; a backslash at the end joins two."""
    for language, body in BLOCK.findall(text):
        if language == "bash":
            yield from (line for line in body.replace("\\\n", " ").splitlines() if line.strip() and not line.startswith("#"))


def calls_of(text):
    """Words behind `omniflight` of every call in the blocks and code spans of a page, with the text they stand in."""
    prose = BLOCK.sub("", text)
    found = [line for language, body in BLOCK.findall(text) if language in ("", "bash") for line in body.replace("\\\n", " ").splitlines()]
    for line in found + SPAN.findall(prose):
        for part in re.split(r"&&|\|\||<\(", line):
            try:
                words = shlex.split(part, comments=line in found)
            except ValueError:
                continue  # no line of a shell: a diagram, a sentence
            if "omniflight" in words[:2] and (words[0] == "omniflight" or words[0] in ("source", "nice")):
                words = words[words.index("omniflight") + 1:]
                end = next((i for i, w in enumerate(words) if w in (">", "|", ";", "&")), len(words))
                yield [w.rstrip(",;)") for w in words[:end]], line


class Options:
    """A verb's options as its --help prints them."""

    def __init__(self, help_text):
        self.takes, self.many, self.choices = {}, set(), {}
        for line in help_text.split("\nOptions:", 1)[1].splitlines():
            if not (found := re.match(r"  (-\S+)(?: (TEXT|INT|UINT|FLOAT)(\S*)(.*))?", line)):
                continue
            names, kind, rule, rest = found.groups()
            for name in names.split(","):
                self.takes[name] = kind is not None
                if kind and re.match(r"(?: in \[[^\]]*\])? \.\.\.", rest):
                    self.many.add(name)
                if kind and (listed := re.match(r":\{(.*?)\}", rule)):
                    self.choices[name] = listed.group(1).split(",")


def placeholder(word):
    """A word that stands for the reader's own: NAME, ..., DIR, a|b."""
    return not word or "..." in word or "|" in word or re.fullmatch(r"[A-Z][A-Z_0-9]*(=\S*)?", word) is not None


class Checker:
    """Says what is wrong with a call: verb, options, their choices, names of vehicles, missions and effects."""

    def __init__(self, run):
        """run(*arguments) -> stdout of the command."""
        self.run, self.options = run, {}
        self.verbs = re.findall(r"^  ([a-z-]+) ", run("--help").split("Subcommands:")[1], re.M)
        self.names = {kind: run("completion", "words", kind).split() for kind in ("vehicles", "missions", "effects", "sensors")}

    def of(self, verb):
        if verb not in self.options:
            self.options[verb] = Options(self.run(verb, "--help"))
        return self.options[verb]

    def unknown(self, kind, word):
        if placeholder(word) or "/" in word or "." in word or word in self.names[kind]:
            return []
        return [f"'{word}' is none of the {kind}"]

    def faults(self, words):
        if not words or words[0].startswith("-") or placeholder(words[0]) or words[0] in ("VERB", "<verb>"):
            return [] if not words or words[0] in ("--version", "--help") or not words[0].startswith("-") else [f"no option {words[0]}"]
        verb, words = words[0], words[1:]
        if verb not in self.verbs:
            return [f"no verb '{verb}'"]
        options, faults, free, open_option = self.of(verb), [], [], None
        for word in words:
            if re.match(r"--?[a-z]", word):
                name, _, value = word.partition("=")
                if name not in options.takes:
                    faults.append(f"{verb} has no option {name}")
                    open_option = None
                    continue
                open_option = name if options.takes[name] and not value else None
            elif open_option:
                faults += self.value(options, open_option, word)
                if open_option not in options.many:
                    open_option = None
            else:
                free.append(word)
        return faults + self.positional(verb, free)

    def value(self, options, name, word):
        kind = {"--vehicle": "vehicles", "--mission": "missions", "--refly": "missions", "--sensors": "sensors", "--why": "effects"}
        if name in options.choices and word not in options.choices[name] and not placeholder(word):
            return [f"{name} takes {', '.join(options.choices[name])}, not '{word}'"]
        return self.unknown(kind[name], word) if name in kind and word != "my_quad" else []

    def positional(self, verb, free):
        kind = {"design": "vehicles", "fly": "missions", "plan": "missions", "effects": "effects"}.get(verb)
        if verb == "plan" and free and free[0] in ("verify", "explain"):
            free = free[1:] if free[0] == "explain" else []
        return self.unknown(kind, free[0]) if kind and free else []
