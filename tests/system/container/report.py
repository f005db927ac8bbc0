# SPDX-License-Identifier: Apache-2.0
"""One line for each check, with what was seen."""

import time
import traceback


class Report:
    def __init__(self):
        self.begin = time.monotonic()
        self.passed = 0
        self.failures = []
        self.lines = []

    def check(self, name, holds, seen=""):
        """Prints whether it holds and what was seen; returns whether it holds."""
        if holds:
            self.passed += 1
        else:
            self.failures.append(name)
        self._line("ok  " if holds else "FAIL", name, seen)
        return holds

    def told(self, name, seen):
        """A figure that nobody has to pass."""
        self._line("told", name, seen)

    def topic(self, name, function, *arguments):
        """Runs a topic; one that cannot go on is a failure, and the next one begins."""
        print(f"\n== {name}", flush=True)
        try:
            function(*arguments)
        except Exception as problem:  # the other topics shall be seen all the same
            traceback.print_exc()
            self.check(f"{name}: ran to its end", False, repr(problem))

    def finish(self):
        """The sum; the exit status."""
        took = time.monotonic() - self.begin
        print(f"\n{self.passed} checks passed, {len(self.failures)} failed, in {took:.0f} s")
        for name in self.failures:
            print(f"  failed: {name}")
        return 1 if self.failures else 0

    def rows(self, where):
        """As rows of a table."""
        cells = ((name, where, seen if word != "FAIL" else f"FAILED: {seen}") for word, name, seen in self.lines)
        return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in cells)

    def _line(self, word, name, seen):
        seen = "; ".join(line.strip() for line in str(seen).splitlines() if line.strip())
        self.lines.append((word, name, seen))
        print(f"[{time.monotonic() - self.begin:6.1f}] {word} {name}" + (f": {seen}" if seen else ""), flush=True)
