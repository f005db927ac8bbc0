#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How the programs were compiled and linked, read from the programs themselves. The words say what they must have:
`link` (position independent, everything relocated at the start and read-only then, no executable stack), `code` (stack
protector, stack clash protection, landing places for indirect jumps), `fortify` (checked functions of the C library).
The programs are those in the folder MBGATE_PROGRAMS, else the installed ones."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
PROGRAMS = ("mbgated", "mbgate-signer", "mbgatectl", "mbgate-sim")
# All sizes that it hands to the C library are constants, which the compiler checks: nothing is left to be checked when it runs.
CHECKED_BY_THE_COMPILER = ("mbgate-signer", "fortify")
EXPECTED = set(sys.argv[1:]) or {"link", "code", "fortify"}
# What functions begin with that may be jumped to, and what a probe of a large stack frame is; by the ELF machine.
X86_64, AARCH64 = "Advanced Micro Devices X86-64", "AArch64"
LANDING = {X86_64: [bytes.fromhex("f30f1efa")], AARCH64: [bytes.fromhex("5f2403d5"), bytes.fromhex("3f2303d5")]}
# sub $0x1000,%rsp; orq $0x0,(%rsp)
PROBE = {X86_64: bytes.fromhex("4881ec00100000 48830c2400")}


def path_of(program):
    folder = os.environ.get("MBGATE_PROGRAMS", os.environ.get("PATH", "") + ":/usr/sbin")
    return shutil.which(program, path=folder)


def readelf(path, *options):
    return subprocess.run(["readelf", "--wide", *options, path], check=True, text=True, capture_output=True,
                          env=os.environ | {"LC_ALL": "C.UTF-8"}).stdout


class Program:
    """What an ELF file says of itself."""

    def __init__(self, path):
        self.path = path
        self.header = readelf(path, "--file-header")
        self.segments = readelf(path, "--program-headers")
        self.dynamic = readelf(path, "--dynamic")
        self.imports = set(re.findall(r" UND (\w+)", readelf(path, "--dyn-syms")))
        self.machine = re.search(r"Machine:\s+(.*)", self.header).group(1)
        self.bytes = pathlib.Path(path).read_bytes()

    def lacks_of_link(self):
        stack = re.search(r"GNU_STACK.* (R\w*) ", self.segments)
        found = {
            "PIE": re.search(r"Type:\s+DYN", self.header) and "Flags: " in self.dynamic
                   and re.search(r"FLAGS_1\).*\bPIE\b", self.dynamic),
            "RELRO": "GNU_RELRO" in self.segments,
            "NOW": re.search(r"\(FLAGS\).*BIND_NOW|\(BIND_NOW\)|FLAGS_1\).*\bNOW\b", self.dynamic),
            "a stack that is not executable": stack and "E" not in stack.group(1),
            "no own search path": not re.search(r"\((RPATH|RUNPATH)\)", self.dynamic),
            "no segment to write and execute": not re.search(r"LOAD.* RWE ", self.segments),
        }
        return [what for what, there in found.items() if not there]

    def lacks_of_code(self):
        landings = sum(self.bytes.count(mark) for mark in LANDING.get(self.machine, ()))
        found = {"the stack protector": "__stack_chk_fail" in self.imports}
        if self.machine in LANDING:
            found["landing places"] = landings > self.code_size() / 1024  # some come with the C library
        if self.machine in PROBE:
            found["stack clash protection"] = PROBE[self.machine] in self.bytes
        return [what for what, there in found.items() if not there]

    def code_size(self):
        return int(re.search(r" \.text +PROGBITS +\w+ +\w+ +(\w+) ", readelf(self.path, "--section-headers")).group(1), 16)

    def lacks_of_fortify(self):
        return [] if any(name.endswith("_chk") for name in self.imports) else ["FORTIFY"]


class Hardening(unittest.TestCase):
    def test_programs_are_hardened(self):
        lacking = {}
        for name in PROGRAMS:
            program = Program(path_of(name))
            for what in sorted(EXPECTED):
                if (name, what) == CHECKED_BY_THE_COMPILER:
                    continue
                if missing := getattr(program, f"lacks_of_{what}")():
                    lacking.setdefault(name, []).extend(missing)
        self.assertEqual(lacking, {})
        if EXPECTED == {"link"}:
            print("only how they are linked: with sanitizers the compiler's own protection is left out")

    def test_a_program_that_is_not_is_seen(self):
        compiler = shutil.which("g++")
        if compiler is None:
            self.skipTest("no compiler")
        folder = self.enterContext(tempfile.TemporaryDirectory())
        source, soft = pathlib.Path(folder) / "soft.cpp", pathlib.Path(folder) / "soft"
        source.write_text("int main() { return 0; }\n", encoding="ascii")
        flags = "-no-pie -fno-pie -fno-stack-protector -fcf-protection=none -Wl,-z,norelro,-z,lazy,-z,execstack".split()
        if os.uname().machine != "x86_64":
            flags.remove("-fcf-protection=none")
        subprocess.run([compiler, *flags, source, "-o", soft], check=True, stderr=subprocess.DEVNULL)
        program = Program(soft)
        self.assertEqual(program.lacks_of_link(), ["PIE", "RELRO", "NOW", "a stack that is not executable"])
        self.assertIn("the stack protector", program.lacks_of_code())
        self.assertEqual(program.lacks_of_fortify(), ["FORTIFY"])


if __name__ == "__main__":
    if shutil.which("readelf") is None or path_of("mbgated") is None:
        print("skipped: readelf (binutils) or the programs are not there")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
