"""Text that hosts pass in, and the messages that they get."""

from __future__ import annotations

import ctypes
import shutil
import struct
from ctypes import byref, c_char_p, c_double, c_int, c_size_t
from pathlib import Path
from typing import Any

import pytest

from fmu_src.native import build
from fmu_src.toolchain.compile import compile_library, host_platform
from harness import ERROR, OK, WARNING, Instance, Unpacked
from torture.raw import Callbacks, Library

_LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, c_char_p, c_int, c_char_p, c_char_p)
FALLBACK = {"mu": 0.6}  # leads to one warning


class Plain:
    """An instance made from bytes as they are; what its logger hears is kept as it comes."""

    def __init__(self, fmu: Unpacked, name: bytes | None, guid: bytes | None = None, location: bytes | None = b""):
        self.library, self.heard = Library(fmu), list[tuple[bytes, int, bytes, bytes]]()
        self.callbacks = Callbacks(logger=_LOGGER(lambda _, *said: self.heard.append(said)))
        guid = fmu.description.guid.encode() if guid is None else guid
        location = (fmu.folder / "resources").as_uri().encode() if location == b"" else location
        make = self.library.functions.fmi2Instantiate
        self.component = make(name, 1, guid, location, byref(self.callbacks), 0, 1)

    def call(self, function: str, *arguments: Any) -> int:
        return int(getattr(self.library.functions, f"fmi2{function}")(self.component, *arguments))

    def begin(self) -> int:
        statuses = [self.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0), self.call("EnterInitializationMode")]
        return max([*statuses, self.call("ExitInitializationMode")])

    def sentence(self) -> str:
        """The one message; it is one line of UTF-8, whatever was passed in."""
        ((name, _, _, text),) = self.heard
        name.decode()
        found = text.decode()
        assert found.isprintable() and ": " in found and len(found) < 700
        return found

    def free(self) -> None:
        if self.component:
            self.library.functions.fmi2FreeInstance(self.component)


NO_UTF8 = {
    "cp1252": "Größe".encode("cp1252"),
    "lone byte": b"a\x80",
    "cut": b"Gr\xc3",
    "overlong": b"\xc0\xaf",
    "overlong of three": b"\xe0\x80\xaf",
    "overlong of four": b"\xf0\x80\x80\xaf",
    "surrogate": b"\xed\xa0\x80",
    "above U+10FFFF": b"\xf4\x90\x80\x80",
    "byte that never is": b"\xff\xfe",
}
ODD = {
    "format": b"100% %s %n %d",
    "control": b"a\x01\n\x7f\tb",
    "long": b"n" * 1_000_000,
    "umlauts": "Größe 車 🚗".encode(),
    "quotes": b"a\"b'c\\d#r1#",
}


@pytest.mark.parametrize("name", NO_UTF8.values(), ids=NO_UTF8)
def test_a_name_that_is_no_utf8_is_refused_in_one_sentence(either_fmu, name):
    plain = Plain(either_fmu, name)
    assert not plain.component and "instance name" in plain.sentence() and "UTF-8" in plain.sentence()


@pytest.mark.parametrize("name", ODD.values(), ids=ODD)
def test_an_odd_name_runs_and_comes_back_as_it_was(either_fmu, name):
    plain = Plain(either_fmu, name)
    assert plain.component and plain.begin() == OK
    assert plain.call("DoStep", 0.0, 0.01, 1) == OK and plain.heard == []
    assert plain.call("DoStep", 0.0, -1.0, 1) == ERROR
    assert [said[0] for said in plain.heard] == [name]
    plain.free()


@pytest.mark.parametrize("name", [None, b""])
def test_no_name_is_refused(either_fmu, name):
    plain = Plain(either_fmu, name)
    assert not plain.component and "instance name" in plain.sentence()


@pytest.mark.parametrize("guid", [b"", b"{" + b"g" * 500_000, b"%n%s%d", *NO_UTF8.values()])
def test_a_guid_of_any_bytes_is_refused_in_one_sentence(either_fmu, guid):
    plain = Plain(either_fmu, b"one", guid)
    assert not plain.component and "GUID" in plain.sentence()


LOCATIONS = [
    None,
    b"file:///",
    b"%",
    b"file:",
    b"file:///%00",
    b"file:///tmp/M%FCller",
    b"/tmp/M\xfcller",
    b"file:///%ED%A0%80",
]
LOCATIONS += [b"file:///" + b"d/" * 50_000, b"/100%n%s", b"file:///a%0Ab", "file:///größe".encode("cp1252")]


@pytest.mark.parametrize("location", LOCATIONS, ids=lambda location: str(location)[:30])
def test_any_location_runs_natively_and_is_refused_in_one_sentence_by_python(native_fmu, python_fmu, location):
    native = Plain(native_fmu, b"one", None, location)
    assert native.component and native.begin() == OK
    native.free()
    python = Plain(python_fmu, b"one", None, location)
    assert not python.component and "resource" in python.sentence()


@pytest.mark.parametrize("folder", [b"M\xfcller", "größe # 100% [1]".encode()])
def test_a_python_fmu_in_a_folder_of_latin_1_is_refused_and_in_one_of_utf8_runs(python_fmu, tmp_path, folder):
    place = bytes(tmp_path) + b"/" + folder
    shutil.copytree(bytes(python_fmu.folder / "resources"), place)
    plain = Plain(python_fmu, b"one", None, place)
    if folder == b"M\xfcller":
        assert not plain.component and "UTF-8" in plain.sentence()
    else:
        assert plain.component and plain.begin() == OK
        plain.free()


CATEGORIES = [*NO_UTF8.values(), b"", b"100%s%n", b"a\nb", b"c" * 1_000_000, None]


@pytest.mark.parametrize("category", CATEGORIES, ids=lambda category: str(category)[:20])
def test_an_unknown_category_enables_nothing_and_is_named(either_fmu, category):
    plain = Plain(either_fmu, b"one")
    reference = either_fmu.reference["mu"]
    assert plain.call("SetReal", (ctypes.c_uint * 1)(reference), 1, byref(c_double(0.6))) == OK
    assert plain.call("SetDebugLogging", 1, 1, (c_char_p * 1)(category)) == OK
    assert "log category" in plain.sentence() and plain.heard[0][1:3] == (WARNING, b"logStatusWarning")
    plain.heard.clear()
    assert plain.begin() == OK and plain.heard == []  # the fallback would warn
    assert plain.call("DoStep", 0.0, -1.0, 1) == ERROR and len(plain.heard) == 1  # a failure is explained in any case
    plain.free()


@pytest.mark.parametrize(
    ("on", "names", "warned"),
    [
        (1, [], True),
        (0, [], False),
        (0, [b"logStatusWarning"], False),
        (1, [b"logStatusWarning"], True),
        (1, [b"logAll"], True),
        (1, [b"logStatusError"], False),
        (1, [b"logStatusWarning", b"logStatusError"], True),
    ],
)
def test_log_categories_are_those_of_the_standard(either_fmu, on, names, warned):
    instance = Instance(either_fmu)
    assert instance.call("fmi2SetDebugLogging", on, len(names), (c_char_p * max(len(names), 1))(*names)) == OK
    assert instance.initialise(FALLBACK) == OK
    assert [status for status, _ in instance.messages] == [WARNING] * warned
    assert instance.step(0.0, -1.0) == ERROR and instance.messages[-1][0] == ERROR
    instance.close()


def test_messages_are_finished_text_with_percent_signs_doubled(either_fmu):
    plain = Plain(either_fmu, b"one")
    assert plain.call("SetDebugLogging", 1, 2, (c_char_p * 2)(b"logAll", b"50% %s")) == OK
    assert b"'50%% %%s'" in plain.heard[0][3]
    plain.free()


def test_cleaning_up_after_an_error_says_no_more(instance):
    assert instance.initialise({"parameter_source": 2}) == OK
    state = ctypes.c_void_p()
    assert instance.call("fmi2GetFMUstate", byref(state)) == OK
    assert instance.step(0.0, -1.0) == ERROR
    said = list(instance.messages)
    assert instance.call("fmi2Terminate") == ERROR
    assert instance.call("fmi2FreeFMUstate", byref(ctypes.c_void_p(4096))) == ERROR
    assert instance.call("fmi2FreeFMUstate", byref(state)) == OK
    assert instance.call("fmi2Reset") == OK
    assert instance.messages == said


# C functions by themselves -----------------------------------------------------------------------------------------

EXPORTS = b"""
#include <stdio.h>
#include "front.h"
#undef snprintf
#define EXPORTED __attribute__((visibility("default")))
EXPORTED int printed(char *text, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = front_print(text, size, format, arguments);
    va_end(arguments);
    return length;
}
EXPORTED void cleaned(const char *text, char *clean) { text_for_logger(text, true, clean); }
EXPORTED int valid(const char *text) { return text_is_utf8(text); }
EXPORTED const char *excerpt(const char *text)
{
    static Excerpt found;
    return text_excerpt(text, &found);
}
/* What the C library of a host with another locale would print. */
EXPORTED int printed_abroad(char *to, size_t size, const char *format, int digits, double value)
{
    char plain[64];
    int length = 0;
    snprintf(plain, sizeof plain, format, digits, value);
    for (const char *at = plain; *at; at++) {
        const char *piece = *at == '.' ? SEPARATOR : (const char[]){*at, 0};
        length += snprintf(to + length, size - (size_t)length, "%s", piece);
    }
    return length;
}
"""
ABROAD = b"int printed_abroad(char *, unsigned long, const char *, int, double);\n"


def functions(folder: Path, separator: str | None = None) -> ctypes.CDLL:
    """Functions of the front; numbers are printed with another decimal separator where one is given."""
    sources = dict(build.native_platoon(2, {}).sources("{none}"))
    exports = EXPORTS.replace(b"SEPARATOR", b'"%s"' % (separator or ".").encode())
    if separator is not None:
        text = sources["front_text.c"].replace(
            b'snprintf(number, sizeof number, "%.*g"', b'printed_abroad(number, 64, "%.*g"'
        )
        assert text != sources["front_text.c"]
        sources["front_text.c"] = ABROAD.replace(b"unsigned long", b"__SIZE_TYPE__") + text
    path = folder / "functions.so"
    path.write_bytes(compile_library(host_platform(), "functions", sources | {"exports.c": exports}))
    loaded = ctypes.CDLL(str(path))
    loaded.excerpt.restype = c_char_p
    return loaded


@pytest.fixture(scope="module")
def front(tmp_path_factory) -> ctypes.CDLL:
    return functions(tmp_path_factory.mktemp("front"))


def printed(front: ctypes.CDLL, size: int, form: bytes, *values: Any) -> tuple[int, bytes]:
    text = ctypes.create_string_buffer(size or 1)
    return front.printed(text, c_size_t(size), form, *values), text.value


@pytest.mark.parametrize("separator", [",", "\u066b", "'"])
def test_numbers_have_a_point_in_every_locale(tmp_path, separator):
    library = functions(tmp_path, separator)
    form, values = b"%.10g m, %.10g s", (c_double(-1234.5), c_double(1.25e-7))
    assert printed(library, 100, form, *values)[1] == b"-1234.5 m, 1.25e-07 s"
    assert printed(library, 100, b"%.10g above %.10g", c_double(35.0 + 1e-12), c_double(35.0))[1].startswith(b"35.0000")


def test_sentences_are_printed_as_python_prints_them(front):
    cases = [
        ("%s = %d of %d", (b"x", -(2**31), 7)),
        ("%.10g", (0.1,)),
        ("%.10g%%", (float("inf"),)),
        ("%.3s", (b"abcdef",)),
    ]
    for form, values in cases:
        given = [c_double(v) if isinstance(v, float) else v for v in values]
        expected = form % tuple(v.decode() if isinstance(v, bytes) else v for v in values)
        length, text = printed(front, 100, form.encode(), *given)
        assert text.decode() == expected and length == len(expected)
        assert printed(front, 3, form.encode(), *given)[1].decode() == expected[:2]
        assert printed(front, 0, form.encode(), *given)[0] == len(expected)


def test_utf8_is_told_from_all_else(front):
    rng_texts = [bytes([a, b]) for a in range(1, 256) for b in range(1, 256)]
    rng_texts += [struct.pack(">I", code).lstrip(b"\0") for code in range(0xEDA07F, 0xEDA083)]
    rng_texts += [
        chr(code).encode("utf-8", "surrogatepass") for code in (*range(0xD7F0, 0xE010), 0xFFFF, 0x10000, 0x10FFFF)
    ]
    for text in rng_texts:
        try:
            text.decode()
            valid = True
        except UnicodeDecodeError:
            valid = False
        assert bool(front.valid(text)) == valid, text
        clean = ctypes.create_string_buffer(2 * len(text) + 1)
        front.cleaned(text, clean)
        assert clean.value.decode().isprintable() or "\u2028" in text.decode(errors="replace") or valid


def test_an_excerpt_is_short_and_valid(front):
    for text in ("ä" * 5000, "a" + "車" * 5000, "🚗" * 100, "x" * 255, "x" * 256):
        found = front.excerpt(text.encode()).decode()
        assert len(found.encode()) < 256 and (found == text or " ... " in found)
