#!/usr/bin/python3
"""Turns the .msg files into one IDL file for idlc and the C++ table of types.

usage: generate_messages.py MSG_DIR OUT_DIR

MSG_DIR/<package>/<Name>.msg in the ROS 2 interface language. Written into OUT_DIR:
  messages.idl        every struct as <package>::msg::dds_::<Name>_, @final, in the order of dependence
  types.hpp           C++ names for the C types, their constants and TypeSupport
  message_table.cpp   ROS name, DDS name, schema text, RIHS01 hash and topic descriptor of every type
Only the standard library is used.
"""
import hashlib
import json
import pathlib
import re
import sys

# ROS primitive -> (IDL type, id in type_description_interfaces/FieldType, C++ type)
PRIMITIVES = {
    "bool": ("boolean", 15, "bool"), "byte": ("octet", 16, "std::uint8_t"), "char": ("uint8", 3, "std::uint8_t"),
    "int8": ("int8", 2, "std::int8_t"), "uint8": ("uint8", 3, "std::uint8_t"),
    "int16": ("short", 4, "std::int16_t"), "uint16": ("unsigned short", 5, "std::uint16_t"),
    "int32": ("long", 6, "std::int32_t"), "uint32": ("unsigned long", 7, "std::uint32_t"),
    "int64": ("long long", 8, "std::int64_t"), "uint64": ("unsigned long long", 9, "std::uint64_t"),
    "float32": ("float", 10, "float"), "float64": ("double", 11, "double"), "string": ("string", 17, None),
}
BOUNDED_STRING = 21  # id in type_description_interfaces/FieldType
ARRAY_OFFSET, SEQUENCE_OFFSET = 48, 144
SEPARATOR = "=" * 80
LINE = re.compile(r"^(?P<type>[A-Za-z][\w/]*)(?:<=(?P<bound>\d+))?(?P<array>\[\d*\])?\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)$")


class Field:
    def __init__(self, package, match):
        self.name = match["name"]
        base = match["type"]
        self.primitive = base if base in PRIMITIVES else None
        self.nested = None if self.primitive else (base if "/" in base else f"{package}/{base}")
        self.bound = int(match["bound"] or 0)  # most characters of a string; 0: any number
        self.is_array = match["array"] is not None
        self.capacity = int(match["array"][1:-1] or 0) if self.is_array else 0

    def idl(self):
        kind = PRIMITIVES[self.primitive][0] if self.primitive else idl_name(self.nested)
        if self.bound:
            kind = f"string<{self.bound}>"
        if self.is_array and not self.capacity:
            return f"sequence<{kind}> {self.name};"
        return f"{kind} {self.name}" + (f"[{self.capacity}];" if self.is_array else ";")

    def description(self):
        offset = 0 if not self.is_array else (ARRAY_OFFSET if self.capacity else SEQUENCE_OFFSET)
        kind = BOUNDED_STRING if self.bound else PRIMITIVES[self.primitive][1] if self.primitive else 1
        return {"name": self.name,
                "type": {"type_id": offset + kind, "capacity": self.capacity, "string_capacity": self.bound,
                         "nested_type_name": long_name(self.nested) if self.nested else ""}}


class Message:
    def __init__(self, path):
        self.package, self.name = path.parent.name, path.stem
        self.key = f"{self.package}/{self.name}"
        self.text = path.read_text(encoding="ascii")
        self.fields, self.constants = [], []
        for number, raw in enumerate(self.text.splitlines(), 1):
            line = raw.split("#", 1)[0].strip()
            if not line:
                continue
            match = LINE.match(line)
            if not match:
                sys.exit(f"{path}:{number}: cannot read '{line}'; write 'type name' or 'type NAME=value'")
            if match["bound"] and match["type"] != "string":
                sys.exit(f"{path}:{number}: '{line}' bounds something that is no string")
            if match["rest"].startswith("="):
                self.constants.append((match["type"], match["name"], match["rest"][1:].strip()))
            else:
                self.fields.append(Field(self.package, match))
        if not self.fields:
            sys.exit(f"{path}: a message needs at least one field")

    def description(self):
        return {"type_name": long_name(self.key), "fields": [field.description() for field in self.fields]}


def long_name(key):
    return key.replace("/", "/msg/")


def idl_name(key):
    return key.replace("/", "::msg::dds_::") + "_"


def c_name(key):
    return key.replace("/", "_msg_dds__") + "_"


def load(folder):
    messages = {m.key: m for m in map(Message, sorted(folder.glob("*/*.msg")))}
    for message in messages.values():
        for field in message.fields:
            if field.nested and field.nested not in messages:
                sys.exit(f"{message.key}.{field.name}: type {field.nested} has no .msg file in {folder}")
    return messages


def referenced(messages, key):
    """Every type that key uses, directly or not, each once, depth first in the order of the fields."""
    found = []

    def visit(name):
        for field in messages[name].fields:
            if field.nested and field.nested not in found:
                found.append(field.nested)
                visit(field.nested)

    visit(key)
    return found


def ordered(messages):
    done, open_names = [], []

    def visit(key):
        if key in done:
            return
        if key in open_names:
            sys.exit(f"{key} contains itself: {' -> '.join(open_names)}")
        open_names.append(key)
        for field in messages[key].fields:
            if field.nested:
                visit(field.nested)
        open_names.pop()
        done.append(key)

    for key in messages:
        visit(key)
    return [messages[key] for key in done]


def type_hash(messages, key):
    """RIHS01: sha256 of the type description as JSON, as rosidl_generator_type_description writes it."""
    others = sorted(referenced(messages, key))
    text = json.dumps({"type_description": messages[key].description(),
                       "referenced_type_descriptions": [messages[other].description() for other in others]},
                      skipkeys=False, ensure_ascii=True, check_circular=True, allow_nan=False, indent=None,
                      separators=(", ", ": "), sort_keys=False)
    return "RIHS01_" + hashlib.sha256(text.encode("utf-8")).hexdigest()


def schema(messages, key):
    """The text that MCAP calls ros2msg: the message, then every type it refers to."""
    parts = [messages[key].text]
    parts += [f"{SEPARATOR}\nMSG: {other}\n{messages[other].text}" for other in referenced(messages, key)]
    return "".join(part if part.endswith("\n") else part + "\n" for part in parts)


def write_idl(order):
    out = ["// Generated from the .msg files by generate_messages.py. Do not edit.", ""]
    for message in order:
        out.append(f"module {message.package} {{ module msg {{ module dds_ {{")
        out.append("@final")
        out.append(f"struct {message.name}_ {{")
        out += [f"  {field.idl()}" for field in message.fields]
        out.append("}; }; }; };")
    return "\n".join(out) + "\n"


def write_types(order):
    out = ["// Generated from the .msg files by generate_messages.py. Do not edit.", "#pragma once", "",
           "#include <cstdint>", "", '#include "omniflight_msgs/message_type.hpp"', '#include "omniflight_msgs/messages.h"',
           "", "namespace omniflight::msgs {", ""]
    for index, message in enumerate(order):
        out.append(f"namespace {message.package} {{")
        out.append(f"using {message.name} = ::{c_name(message.key)};")
        for kind, name, value in message.constants:
            out.append(f"inline constexpr {PRIMITIVES[kind][2]} {message.name}_{name} = {value};")
        out.append(f"}}  // namespace {message.package}")
        out += ["template <>", f"struct TypeSupport<{message.package}::{message.name}> {{",
                f"  static const MessageType& type() {{ return message_types()[{index}]; }}", "};", ""]
    out.append("}  // namespace omniflight::msgs")
    return "\n".join(out) + "\n"


def write_table(messages, order):
    out = ["// Generated from the .msg files by generate_messages.py. Do not edit.",
           '#include "omniflight_msgs/message_type.hpp"', '#include "omniflight_msgs/messages.h"', "",
           "namespace omniflight::msgs {", "namespace {", "const MessageType g_types[] = {"]
    for message in order:
        key = message.key
        out.append(f'{{"{long_name(key)}", "{idl_name(key)}", R"schema({schema(messages, key)})schema",')
        out.append(f' "{type_hash(messages, key)}", &{c_name(key)}_desc, sizeof({c_name(key)})}},')
    out += ["};", "}  // namespace", "std::span<const MessageType> message_types() { return g_types; }",
            "}  // namespace omniflight::msgs"]
    return "\n".join(out) + "\n"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    messages = load(pathlib.Path(sys.argv[1]))
    order = ordered(messages)
    out = pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    for name, text in (("messages.idl", write_idl(order)), ("types.hpp", write_types(order)),
                       ("message_table.cpp", write_table(messages, order))):
        (out / name).write_text(text, encoding="ascii")


if __name__ == "__main__":
    main()
