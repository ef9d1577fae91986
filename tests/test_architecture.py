#!/usr/bin/python3
"""Holds the workspace against docs/explanation/architecture.md: dependencies point downward, and the bus does not leak.

Reads every src/*/package.xml, CMakeLists.txt and #include, and fails on
  - an edge between packages that is not downward (nor one of the few named sideways ones),
  - an edge that CMake or an #include uses and package.xml does not declare (colcon would build in a wrong order),
  - a package that has no level yet, or an edge to a package that does not exist,
  - dds/*.h outside the packages of the bus, or in a public header of the bus,
  - an include between the rooms of a package (folders of its src/) that points upward,
  - a constant or class in the anonymous namespaces of two sources of one folder, which a build may join,
  - the id of an effect as a literal outside omniflight_physics (effect_ids.hpp has names for those that are needed).
Before that it checks itself: on a made-up workspace each of these faults must be found, and nothing else.

Example: tests/test_architecture.py [WORKSPACE]
"""
import re
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

LEVELS = {
    "cmake": 0, "core": 0, "files": 0, "msgs": 0,
    "vehicle": 1, "physics": 1, "jobs": 1,
    "allocation": 2, "control": 2, "planning": 2, "recording": 2, "identification": 2, "gateway": 2, "safety": 2,
    "simulation": 3, "diagnosis": 3, "report": 3, "view": 3,
    "bus": 4, "reproduction": 4, "campaign": 4,
    "components": 5, "cli": 5, "proof": 5, "python": 5,
}
# Within a level only these; everything may use the build conventions of omniflight_cmake.
SIDEWAYS = {("files", "core"), ("physics", "vehicle"), ("planning", "allocation"), ("cli", "components")}
# Downward, and yet forbidden, also through others: the proof is worth something only if its plant shares no dynamics
# with ours.
FORBIDDEN = {("proof", "physics"): "the proof shares no dynamics code",
             ("proof", "simulation"): "the proof shares no dynamics code",
             ("proof", "diagnosis"): "the proof is not to know what it examines"}
DDS_PACKAGES = {"bus", "components", "msgs"}
# Rooms of a package, as packages themselves; what stands in src/ itself may use all. Rooms of one level that are named
# together in TOGETHER know each other.
ROOMS = {"diagnosis": {"numerics": 0, "conditioning": 1, "monitoring": 1, "regression": 2, "drive": 3, "sensor_checks": 3, "evidence": 4,
                       "discrepancy": 4, "search": 4, "validation": 5, "experiment_design": 5, "report": 5}}
TOGETHER = {"diagnosis": {"evidence", "discrepancy", "search"}}
# Ids of effects belong to physics; the worlds of the proof are independent on purpose, and tests name what they try.
EFFECTS_IN, NAMES_EFFECTS, TRIES = "physics", {"physics", "proof"}, {"test", "benchmark"}
# Other things that have the name of an effect: kinds of tolerances and of faults.
SAME_NAME = {("src/omniflight_vehicle/src/load.cpp", "thrust_scale"),
             ("src/omniflight_diagnosis/src/conditioning/prior_knowledge.cpp", "thrust_scale"),
             ("src/omniflight_diagnosis/src/regression/calibration.cpp", "thrust_scale"),
             ("src/omniflight_simulation/src/fault_file.cpp", "gust")}

PREFIX = "omniflight_"
DEPEND_TAGS = {"depend", "build_depend", "build_export_depend", "exec_depend", "test_depend", "buildtool_depend",
               "buildtool_export_depend"}
LINKING = {"find_package", "target_link_libraries", "list", "set", "omniflight_library", "omniflight_executable",
           "omniflight_tests", "omniflight_benchmarks"}
SOURCES = {".h", ".hpp", ".c", ".cpp", ".cc", ".in", ".ipp"}


def declared(package):
    """Names of omniflight packages that package.xml depends on, without the prefix."""
    root = ET.parse(package / "package.xml").getroot()
    names = {e.text.strip() for e in root if e.tag in DEPEND_TAGS and e.text}
    return {n[len(PREFIX):] for n in names if n.startswith(PREFIX)}


def cmake_commands(text):
    """(command, words) of a CMakeLists.txt, with foreach(variable words...) unrolled."""
    text = re.sub(r"#[^\n]*", "", text)
    out, loops = [], []
    for command, arguments in re.findall(r"(\w+)\s*\(([^()]*)\)", text):
        words = arguments.replace('"', " ").split()
        if command.lower() == "foreach" and words:
            loops.append((words[0], [w for w in words[1:] if w not in ("IN", "ITEMS", "LISTS")]))
            continue
        if command.lower() == "endforeach" and loops:
            loops.pop()
            continue
        variants = [words]
        for variable, values in loops:
            pattern = "${" + variable + "}"
            variants = [[w.replace(pattern, v) for w in variant] for variant in variants
                        for v in (values if any(pattern in w for w in variant) else [pattern])]
        out += [(command.lower(), v) for v in variants]
    return out


def linked(package, own):
    """Names of omniflight packages that CMakeLists.txt finds or links, without the prefix."""
    names, programs = set(), {"omniflight_warnings"}
    commands = cmake_commands((package / "CMakeLists.txt").read_text(encoding="utf-8"))
    for command, words in commands:
        if command in ("omniflight_executable", "add_executable", "add_library") and words:
            programs.add(words[0])
    for command, words in commands:
        if command not in LINKING:
            continue
        for word in words:
            match = re.search(r"\bomniflight_\w+", word)
            if match and match.group(0) not in programs and "${" not in word:
                names.add(match.group(0)[len(PREFIX):])
    return names - {own}


def source_files(package):
    return sorted(p for p in package.rglob("*") if p.suffix in SOURCES and p.is_file())


def included(package, own):
    """{omniflight package: first file that includes one of its headers}, without the prefix."""
    out = {}
    for file in source_files(package):
        text = file.read_text(encoding="utf-8", errors="replace")
        for name in re.findall(r'^\s*#\s*include\s*[<"]omniflight_(\w+)/', text, re.M):
            if name != own:
                out.setdefault(name, file)
    return out


def room_faults(package, folder):
    """Sentences on includes between rooms of one package that point upward, and on rooms without a level."""
    faults, rooms, source = [], ROOMS[package], (folder / "src").resolve()
    for file in sorted(p for p in source.rglob("*") if p.suffix in SOURCES and p.parent != source):
        own = file.relative_to(source).parts[0]
        where = f"src/{PREFIX}{package}/src/{file.relative_to(source)}"
        if own not in rooms:
            faults.append(f"{where}: room {own} has no level; add it to ROOMS in tests/test_architecture.py")
            continue
        for include in re.findall(r'^\s*#\s*include\s*"([^"]+)"', file.read_text(encoding="utf-8"), re.M):
            target = (file.parent / include).resolve()
            if not target.is_relative_to(source) or not target.exists():
                continue
            other = target.relative_to(source).parts[0] if target.parent != source else "(root)"
            good = other == own or rooms.get(other, 9) < rooms[own] or {own, other} <= TOGETHER.get(package, set())
            if not good:
                faults.append(f"{where}: includes {include}, which is not below room {own}")
    return faults


def literals(text):
    """(line number, content) of the string literals of C++ code; comments have none, and what a raw string holds is text."""
    token = re.compile(r'R"([^()\\ ]*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|\'(?:\\.|[^\'\\\n])\'|"((?:\\.|[^"\\\n])*)"', re.S)
    return [(text.count("\n", 0, m.start()) + 1, m.group(2)) for m in token.finditer(text) if m.group(2) is not None]


def effect_ids(packages):
    """Ids that the files of effects declare."""
    folder = packages.get(EFFECTS_IN, Path("/nonexistent")) / "src" / "effects"
    return {i for f in folder.glob("*.cpp") for i in re.findall(r'\.id\s*=\s*"(\w+)"', f.read_text(encoding="utf-8"))}


def effect_faults(workspace, packages):
    """Sentences on effects that are named by a literal where only physics knows them."""
    faults, ids = [], effect_ids(packages)
    for name, folder in packages.items():
        if name in NAMES_EFFECTS or not ids:
            continue
        for file in source_files(folder):
            if TRIES & set(file.relative_to(folder).parts[:-1]):
                continue
            where = str(file.relative_to(workspace))
            for line, text in literals(file.read_text(encoding="utf-8", errors="replace")):
                if text in ids and (where, text) not in SAME_NAME:
                    faults.append(f'{where}:{line}: names the effect "{text}"; let the effect state what is special about it '
                                  f"(EffectInfo), or use effect_id::{text} (effect_ids.hpp)")
    return faults


def private_names(text):
    """Constants and classes that the anonymous namespaces of a C++ source define."""
    inside = "\n".join(re.findall(r"^namespace \{$(.*?)^\}  // namespace$", text, re.M | re.S))
    constants = re.findall(r"^(?:const|constexpr)\b[^;={(]*?\b(k[A-Z]\w*)(?:\[\w*\])*\s*[={]", inside, re.M)
    return set(constants + re.findall(r"^(?:struct|class|enum class) (\w+)[^;]*?\{", inside, re.M))


def joined_faults(workspace, packages):
    """Sentences on names that clash where the sources of a folder are joined (omniflight_join)."""
    faults = []
    for folder in packages.values():
        first = {}
        for file in sorted((folder / "src").rglob("*.cpp")):
            for name in sorted(private_names(file.read_text(encoding="utf-8", errors="replace"))):
                other = first.setdefault((file.parent, name), file)
                if other != file:
                    faults.append(f"{file.relative_to(workspace)}: {name} is a name in {other.name} too, and a build joins them")
    return faults


def reachable(start, edges):
    """Everything that `start` depends on, directly or through others."""
    seen, todo = set(), [start]
    while todo:
        for name in edges.get(todo.pop(), ()):
            if name not in seen:
                seen.add(name)
                todo.append(name)
    return seen


def edge_fault(a, b, present):
    """Why package a must not depend on package b; None when it may."""
    if b not in present:
        return f"there is no package {PREFIX}{b} in src/"
    if b not in LEVELS:
        return f"{PREFIX}{b} has no level"
    if (a, b) in FORBIDDEN:
        return FORBIDDEN[a, b]
    if b == "cmake" or LEVELS[b] < LEVELS[a] or (a, b) in SIDEWAYS:
        return None
    way = "sideways" if LEVELS[a] == LEVELS[b] else "upward"
    return f"points {way} (level {LEVELS[a]} to level {LEVELS[b]})"


def check(workspace):
    """Returns (faults, edges, files): sentences, {package: names}, number of source files read."""
    faults, edges, uses, files = [], {}, {}, 0
    packages = {p.parent.name[len(PREFIX):]: p.parent for p in sorted(workspace.glob(f"src/{PREFIX}*/package.xml"))}
    for folder in sorted(workspace.glob("src/*")):
        if folder.is_dir() and not (folder / "package.xml").is_file():
            faults.append(f"src/{folder.name}: no package.xml")
    for name, folder in packages.items():
        if name not in LEVELS:
            faults.append(f"{PREFIX}{name}: has no level; add it to LEVELS in tests/test_architecture.py and to "
                          "docs/explanation/architecture.md")
            continue
        edges[name] = declared(folder)
        uses[name] = [("CMakeLists.txt", n) for n in sorted(linked(folder, name))]
        uses[name] += [(str(f.relative_to(folder)), n) for n, f in sorted(included(folder, name).items())]
    for name in edges:
        known = reachable(name, edges)
        named = [("package.xml", n) for n in sorted(edges[name])] + uses[name]
        for where, other in named:
            why = edge_fault(name, other, packages)
            if why:
                faults.append(f"{PREFIX}{name} -> {PREFIX}{other} ({where}): {why}")
            elif other not in known:
                faults.append(f"{PREFIX}{name} -> {PREFIX}{other} ({where}): package.xml does not declare it")
    for (a, b), why in FORBIDDEN.items():
        through = sorted(c for c in edges.get(a, ()) if b in reachable(c, edges))
        if through and b not in edges[a]:
            faults.append(f"{PREFIX}{a} -> {PREFIX}{b} (through {', '.join(PREFIX + c for c in through)}): {why}")
    for name in sorted(ROOMS.keys() & packages.keys()):
        faults += room_faults(name, packages[name])
    faults += effect_faults(workspace, packages) + joined_faults(workspace, packages)
    for name, folder in packages.items():
        for file in source_files(folder):
            files += 1
            if not re.search(r'^\s*#\s*include\s*[<"]dds/', file.read_text(encoding="utf-8", errors="replace"), re.M):
                continue
            where = file.relative_to(workspace)
            if name not in DDS_PACKAGES:
                faults.append(f"{where}: includes dds/, which only {', '.join(sorted(DDS_PACKAGES))} may")
            elif file.is_relative_to(folder / "include"):
                faults.append(f"{where}: a public header includes dds/")
    return faults, edges, files


def write_package(workspace, name, depends=(), cmake=(), files=()):
    folder = workspace / "src" / (PREFIX + name)
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(
        f"<package format='3'><name>{PREFIX}{name}</name>" +
        "".join(f"<depend>{PREFIX}{d}</depend>" for d in depends) + "</package>")
    (folder / "CMakeLists.txt").write_text(
        f"project({PREFIX}{name})  # find_package(omniflight_nothing)\n" +
        "".join(f"foreach(p {c})\n  find_package(omniflight_${{p}} REQUIRED)\nendforeach()\n" for c in cmake))
    for path, text in dict(files).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)


def self_test():
    """Each fault must be found, and a sound workspace must pass. Returns the number of cases."""
    sound = [("core", [], [], {}),
             ("vehicle", ["core"], ["core"], {"src/a.cpp": '#include "omniflight_core/result.hpp"\n'}),
             ("physics", ["vehicle"], ["vehicle core"], {"src/effects/gust.cpp": '.id = "gust",\n'}),
             ("simulation", ["physics"], ["physics"], {}),
             ("bus", ["core"], ["core"], {"src/b.cpp": "#include <dds/dds.h>\n"})]
    cases = [
        ("sound", [], []),
        ("upward in package.xml", [("planning", ["simulation"], [], {})],
         ["omniflight_planning -> omniflight_simulation (package.xml): points upward (level 2 to level 3)"]),
        ("upward in CMake only", [("planning", [], ["core bus"], {})],
         ["omniflight_planning -> omniflight_bus (CMakeLists.txt): points upward (level 2 to level 4)",
          "omniflight_planning -> omniflight_core (CMakeLists.txt): package.xml does not declare it"]),
        ("upward by include only", [("control", ["core"], [], {"src/c.cpp": '#include "omniflight_bus/qos.hpp"\n'})],
         ["omniflight_control -> omniflight_bus (src/c.cpp): points upward (level 2 to level 4)"]),
        ("sideways", [("gateway", [], [], {}), ("control", ["gateway"], [], {})],
         ["omniflight_control -> omniflight_gateway (package.xml): points sideways (level 2 to level 2)"]),
        ("forbidden", [("proof", ["physics"], [], {})],
         ["omniflight_proof -> omniflight_physics (package.xml): the proof shares no dynamics code"]),
        ("forbidden through others", [("report", ["simulation"], [], {}), ("proof", ["report"], [], {})],
         ["omniflight_report -> omniflight_simulation (package.xml): points sideways (level 3 to level 3)",
          "omniflight_proof -> omniflight_physics (through omniflight_report): the proof shares no dynamics code",
          "omniflight_proof -> omniflight_simulation (through omniflight_report): the proof shares no dynamics code"]),
        ("absent", [("control", ["report"], [], {})],
         ["omniflight_control -> omniflight_report (package.xml): there is no package omniflight_report in src/"]),
        ("without level", [("extra", [], [], {})],
         ["omniflight_extra: has no level; add it to LEVELS in tests/test_architecture.py and to "
          "docs/explanation/architecture.md"]),
        ("dds below the bus", [("control", ["core"], [], {"test/t.hpp": '  #include "dds/ddsc.h"\n'})],
         ["src/omniflight_control/test/t.hpp: includes dds/, which only bus, components, msgs may"]),
        ("dds in a public header", [("msgs", [], [], {"include/m.hpp": "#include <dds/dds.h>\n"})],
         ["src/omniflight_msgs/include/m.hpp: a public header includes dds/"]),
        ("rooms", [("diagnosis", [], [], {
            "src/all.cpp": '#include "report/a.hpp"\n', "src/root.hpp": "", "src/report/a.hpp": '#include "../search/b.hpp"\n',
            "src/search/b.hpp": '#include "../evidence/c.hpp"\n', "src/evidence/c.hpp": '#include "../search/b.hpp"\n',
            "src/regression/d.cpp": '#include "../search/b.hpp"\n', "src/search/e.cpp": '#include "../root.hpp"\n',
            "src/attic/f.cpp": ""})],
         ["src/omniflight_diagnosis/src/regression/d.cpp: includes ../search/b.hpp, which is not below room regression",
          "src/omniflight_diagnosis/src/search/e.cpp: includes ../root.hpp, which is not below room search",
          "src/omniflight_diagnosis/src/attic/f.cpp: room attic has no level; add it to ROOMS in tests/test_architecture.py"]),
        ("names that clash where sources are joined", [
            ("view", [], [], {
                "src/a.cpp": "namespace {\n\nconstexpr double kFar = 1;\nstruct Line {\n  int k;\n};\n}  // namespace\n",
                "src/b.cpp": "namespace {\nconstexpr int kFar = 2;\nusing Line = int;\nint f() { return kFar; }\n}  // namespace\n",
                "src/c/c.cpp": "namespace {\nconstexpr int kFar = 3;\n}  // namespace\n"})],
         ["src/omniflight_view/src/b.cpp: kFar is a name in a.cpp too, and a build joins them"]),
        ("effects by name", [
            ("view", ["physics"], [], {
                "src/a.cpp": '// "gust"\nf("calm", \'"\', "gust");\n', "test/b.cpp": 'f("gust");\n',
                "src/c.cpp": '/* "gust" */ R"x({"gust"})x"; "a \\"gust\\" of wind"; R"(")"; f("gusts");\n'}),
            ("proof", [], [], {"src/d.cpp": 'f("gust");\n'})],
         ['src/omniflight_view/src/a.cpp:2: names the effect "gust"; let the effect state what is special about it '
          "(EffectInfo), or use effect_id::gust (effect_ids.hpp)"]),
    ]
    for title, extra, expected in cases:
        with tempfile.TemporaryDirectory() as folder:
            for package in sound + extra:
                write_package(Path(folder), *package)
            faults = check(Path(folder))[0]
        if sorted(faults) != sorted(expected):
            sys.exit(f"self-test '{title}' failed:\n  found    {faults}\n  expected {expected}")
    return len(cases)


def main():
    if len(sys.argv) > 2 or (len(sys.argv) == 2 and sys.argv[1].startswith("-")):
        print(__doc__)
        return 0 if sys.argv[1] in ("-h", "--help") else 4
    workspace = Path(sys.argv[1] if len(sys.argv) == 2 else Path(__file__).parent.parent).resolve()
    print(f"self-test: {self_test()} cases, each fault is found")
    faults, edges, files = check(workspace)
    if not edges:
        print(f"{workspace}: no packages under src/", file=sys.stderr)
        return 4
    for name in sorted(edges, key=lambda n: (LEVELS[n], n)):
        others = sorted(edges[name] - {"cmake"}, key=lambda n: (LEVELS.get(n, 9), n))
        print(f"L{LEVELS[name]} {name:<15} -> {' '.join(others) or '-'}")
    print(f"checked {len(edges)} packages, {sum(map(len, edges.values()))} declared dependencies, "
          f"{files} source files: {len(faults)} faults")
    for fault in faults:
        print("FAULT " + fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
