"""What the front leaves in memory, and two threads that call one instance at once."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from fmu_src.native import build
from fmu_src.toolchain.compile import fmi_headers
from system_packages import require

WATCHER = r"""
#include <malloc.h>
#include <string.h>
extern void __libc_free(void *);
int watched;
void free(void *block) /* loaded before the C library's: counts blocks that still look like an instance */
{
    const char *at = block;
    const size_t size = block ? malloc_usable_size(block) : 0;
    for (size_t i = 0; i + 8 <= size; i += 8) watched += memcmp(at + i, "NORF_PSP", 8) == 0;
    __libc_free(block);
}
"""

LIFE = r"""
#include <stdio.h>
#include <string.h>
#include "fmi2Functions.h"
#include "psp_model.h"
__attribute__((weak)) extern int watched;
static void say(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...) {}
int main(void)
{
    const fmi2CallbackFunctions callbacks = {say, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, PSP_GUID, NULL, &callbacks, 0, 0);
    if (!&watched || !c || memcmp(c, "NORF_PSP", 8) != 0) return 2;
    fmi2FreeInstance(c);
    printf("%d\n", watched);
    return 0;
}
"""


def _program(folder: Path, source: str, *options: str) -> list[str]:
    require("gcc")
    sources = build.native_platoon(2, {}).sources("{x}") | fmi_headers() | {"main.c": source.encode()}
    for name, content in sources.items():
        (folder / name).write_bytes(content)
    files = sorted(name for name in sources if name.endswith(".c"))
    command = ["gcc", "-std=gnu11", *options, "-o", "program", *files, "-lm", "-lpthread"]
    subprocess.run(command, cwd=folder, check=True)
    return [str(folder / "program")]


@pytest.mark.parametrize("options", [["-O3"], ["-O3", "-flto"]])
def test_a_freed_instance_is_no_instance_any_more(tmp_path, options):
    """The compiler knows nothing of the `free` that looks: it is loaded when the program runs."""
    program = _program(tmp_path, LIFE, "-fPIE", "-pie", *options)
    (tmp_path / "watcher.c").write_text(WATCHER)
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", "watcher.so", "watcher.c"], cwd=tmp_path, check=True)
    environment = os.environ | {"LD_PRELOAD": str(tmp_path / "watcher.so")}
    ran = subprocess.run(program, env=environment, capture_output=True, text=True, check=True)
    assert ran.stdout == "0\n"


RACE = r"""
#include <pthread.h>
#include <stdio.h>
#include "fmi2Functions.h"
#include "psp_model.h"
enum { ROUNDS = 5000 };
static fmi2Component c;
static int taken[2], refused[2];
static void say(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String category, fmi2String m, ...) {}
static void *call(void *which)
{
    const long me = (long)which;
    for (int k = 0; k < ROUNDS; k++) {
        const fmi2ValueReference input = PSP_FIRST_INPUT;
        fmi2Real value = 0.0;
        const fmi2Status status = k % 3 == 0   ? fmi2SetReal(c, &input, 1, &value)
                                  : k % 3 == 1 ? fmi2GetReal(c, &input, 1, &value)
                                               : fmi2DoStep(c, 0.0, 0.0, fmi2True);
        if (status == fmi2OK) taken[me]++;
        else if (status == fmi2Error) refused[me]++;
    }
    return NULL;
}
int main(void)
{
    const fmi2CallbackFunctions callbacks = {say, NULL, NULL, NULL, NULL};
    pthread_t threads[2];
    c = fmi2Instantiate("one", fmi2CoSimulation, PSP_GUID, NULL, &callbacks, 0, 1);
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    for (long i = 0; i < 2; i++) pthread_create(&threads[i], NULL, call, (void *)i);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    printf("%d %d\n", taken[0] + refused[0] == ROUNDS && taken[1] + refused[1] == ROUNDS,
           taken[0] > 0 && taken[1] > 0 && fmi2DoStep(c, 0.0, 0.01, fmi2True) == fmi2OK);
    fmi2FreeInstance(c);
    return 0;
}
"""


def test_of_two_threads_that_call_at_once_one_is_refused(tmp_path):
    """ThreadSanitizer sees any two calls that are inside one instance together."""
    try:
        program = _program(tmp_path, RACE, "-O1", "-g", "-fsanitize=thread")
    except subprocess.CalledProcessError:
        pytest.skip("gcc has no ThreadSanitizer here: install libtsan")
    ran = subprocess.run(program, capture_output=True, text=True, check=False)
    assert ran.stdout == "1 1\n" and ran.returncode == 0, ran.stderr[:3000]
