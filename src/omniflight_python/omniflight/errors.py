"""The one exception of the package."""

import re

_WHERE = re.compile(r"^(?P<file>.+?)(?::(?P<line>\d+))?(?:: (?P<field>\S.*))?$", re.DOTALL)
_UNIT = re.compile(r"\bis -?[0-9][0-9.e+-]* (?P<unit>[A-Za-z%][A-Za-z0-9/^*%]*)(?=[ ,.;)]|$)")


class Error(Exception):
    """What could not be done, and why.

    code       'bad_input' (a file, option or value that cannot be used), 'incomplete' (the work ended without the
               wanted result), 'impossible' (proven so) or 'internal' (a fault of ours)
    message    one sentence with value and unit
    where      'file:line: field', as far as it is known
    file, line, field
               its parts; '' and None where they are not known
    unit       of the value that the message names, '' when it names none
    next_step  what to do about it
    """

    def __init__(self, code, message, where="", next_step=""):
        self.code, self.message, self.where, self.next_step = code, message, where, next_step
        parts = _WHERE.match(where)
        self.file = parts["file"] if parts else ""
        self.line = int(parts["line"]) if parts and parts["line"] else None
        self.field = (parts["field"] or "") if parts else ""
        unit = _UNIT.search(message)
        self.unit = unit["unit"] if unit else ""
        text = f"{where}: {message}" if where else message
        super().__init__(f"{text}. {next_step}" if next_step else text)

    def __reduce__(self):
        return (Error, (self.code, self.message, self.where, self.next_step))
