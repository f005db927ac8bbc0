#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the measurements of bench/README.md: prints its table, keeps what mbgate-bench wrote, and draws the plots.

usage: figures.py [--programs FOLDER] [--only NAME,...] [--scale FACTOR] [--command NAME=COMMAND]... OUTPUT

--programs  the folder of mbgate-bench and mbgated (default: build/release/bin)
--command   another gateway, as mbgate-bench takes it; what needs one that is not given is left out
--scale     makes each run so much longer or shorter
OUTPUT      a folder for the JSON of each measurement and the plots (SVG, by gnuplot)
"""

import argparse
import json
import pathlib
import shlex
import shutil
import statistics
import subprocess
import sys

BAUDS = (9600, 19200, 115200, 921600)


class Measurement:
    """One call of mbgate-bench, and the rows that come of it."""

    def __init__(self, name, arguments, seconds, pairs, *rows):
        self.name = name
        self.arguments = arguments.split()
        self.seconds = seconds
        self.pairs = pairs
        self.rows = rows

    def needs(self):
        """The contestants that are neither ours nor floors."""
        words = {word.split(":")[0] for word in self.arguments if not word.startswith("--")}
        return words & {"mbusd", "peer"}

    def command(self, scale, commands):
        given = [f"--command={name}={text}" for name, text in commands.items() if name in self.needs()]
        seconds = round(self.seconds * scale, 1)
        return ["mbgate-bench", *self.arguments, f"--seconds={seconds:g}", f"--pairs={self.pairs}", *given]


def figure(contestants, which, key):
    """The median of one contestant."""
    return contestants[which]["median"][key]


def against(contestants, which, key):
    """The median over the pairs against the first contestant."""
    return contestants[which]["against_first"][key]


def ratio_of(contestants, which, other, key):
    """The median over the pairs of one contestant against another."""
    runs = zip(contestants[which]["runs"], contestants[other]["runs"])
    return statistics.median(mine[key] / theirs[key] for mine, theirs in runs)


def ratio_row(title, goal, key, which=1, other=0):
    return title, goal, lambda c: f"{ratio_of(c, which, other, key):.3f} x"


def ratio_and_figures(title, goal, key):
    """The ratio, and both figures."""
    return title, goal, lambda c: (f"{ratio_of(c, 1, 0, key):.3f} x ({figure(c, 1, key):.2f} to {figure(c, 0, key):.2f})")


def per_connection(contestants):
    more = contestants[1]["scenario"]["idle"] - contestants[0]["scenario"]["idle"]
    return f"{against(contestants, 1, 'resident_kib') / more:.2f} KiB"


def slowest_bus(contestants):
    runs = zip(contestants[0]["runs"], contestants[1]["runs"])
    share = statistics.median(many["least_bus_per_second"] / one["wire_per_second"] for one, many in runs)
    return f"{100 * share:.1f} % (the slowest of them)"


def dead_time(goal, percentile):
    key = f"dead_time_{percentile}_us"
    return (f"dead time above the master's, 115200 baud, {percentile}", goal,
            lambda c: f"{against(c, 1, key):+.1f} us ({figure(c, 1, key):.1f} to {figure(c, 0, key):.1f})")


def faults(contestants):
    """What went wrong in any run, of anybody: a figure that comes of it must not be taken for a clean one."""
    found = []
    for one in contestants:
        for kind in ("violations", "bad_frames", "wrong", "lost", "unanswered"):
            if one["median"][kind]:
                found.append(f"{one['scenario']['name']}: {one['median'][kind]:g} {kind}")
    return f" ({', '.join(found)})" if found else ""


def share_of_wire(baud, goal, seconds):
    rows = [ratio_and_figures(f"share of the wire's limit (%) against the bare master's, {baud} baud", goal, "share_percent")]
    if baud == 115200:
        rows += [dead_time("<= 40 us", "p50"), dead_time("<= 80 us", "p90"), dead_time("printed", "p99")]
    rows.append((f"silence violations, {baud} baud", "0", lambda c: f"{figure(c, 1, 'violations'):g}"))
    return Measurement(f"share-{baud}", f"--baud {baud} master mbgated", seconds, 9, *rows)


def unpaced(clients):
    return Measurement(
        f"unpaced-{clients}", f"--baud 0 --clients {clients} --no-coalesce peer relay mbgated", 2, 11,
        ratio_row(f"requests a second against the relay, not paced, {clients} clients", ">= 0.9 x",
                  "answers_per_second", 2, 1),
        ratio_row(f"the same against the fastest peer, {clients} clients", ">= 1.05 x", "answers_per_second", 2),
        ratio_row(f"CPU an answer against the fastest peer, {clients} clients", "<= 1.0 x", "processor_us", 2))


MEASUREMENTS = (
    share_of_wire(9600, ">= 0.995 x", 6),
    share_of_wire(19200, ">= 0.995 x", 4),
    share_of_wire(115200, ">= 0.99 x", 3),
    share_of_wire(921600, ">= 0.98 x", 3),
    Measurement("mbusd", "mbusd mbgated", 3, 5,
                ratio_and_figures("transactions a second against mbusd at -R 2, 115200 baud", ">= 1.05 x", "wire_per_second")),
    Measurement("one-client", "--baud 0 --clients 1 relay mbgated", 3, 9,
                ratio_and_figures("latency p50 (us) against the relay, not paced, one client", "<= 1.25 x", "latency_p50_us")),
    unpaced(8),
    unpaced(32),
    Measurement("processor-mbusd", "--baud 0 --clients 8 --no-coalesce mbusd mbgated", 3, 5,
                ratio_and_figures("CPU an answer (us) against mbusd, 8 clients", "<= 0.5 x", "processor_us")),
    Measurement("buses-16", "mbgated mbgated:buses=16,clients=128", 3, 5,
                ("16 buses at 115200 baud: each one's share of what one alone gets", ">= 97 %", slowest_bus)),
    Measurement("connections", "--clients 100 mbgated mbgated:idle=9900", 5, 3,
                ratio_and_figures("latency p99 (us) of 100 active of 10,000 connections against the 100 alone", "<= 1.2 x",
                         "latency_p99_us"),
                ("memory (RSS) a connection", "<= 4 KiB", per_connection)),
    Measurement("flood", "mbgated mbgated:flood=1 mbgated:flood=8", 3, 5,
                ratio_row("garbage without end on another listener, 1 connection: throughput", ">= 0.95 x",
                          "wire_per_second"),
                ratio_row("the same, 8 connections", ">= 0.95 x", "wire_per_second", 2)),
    Measurement("idle", "--clients 0 --idle 100 mbgated", 60, 1,
                ("context switches in 60 s, a line open, 100 silent connections", "0",
                 lambda c: f"{figure(c, 0, 'switches_per_second') * 60:.0f}")),
    Measurement("allocations", "--baud 0 --allocations mbgated", 5, 1,
                ("allocations in 1,000 transactions, in the daemon", "< 1",
                 lambda c: f"{figure(c, 0, 'allocations_per_thousand'):.3f}")),
    Measurement("same-registers", "--devices 1 --same mbgated:clients=1 mbgated:clients=32", 3, 5,
                ratio_row("32 clients on the same registers against one alone", ">= 30 x", "answers_per_second")),
    Measurement("dead-device", "--devices 8 --warm-up 4 mbgated:devices=7,clients=7 mbgated:dead=1,clients=8", 5, 3,
                ratio_row("one dead device of eight: answers of the seven others", ">= 0.97 x", "answers_per_second")),
    # What the plots show besides.
    Measurement("registers", "mbgated:registers=1 mbgated:registers=10 mbgated:registers=50 mbgated:registers=125", 3, 3),
    Measurement("clients", "mbgated:clients=1 mbgated:clients=8 mbgated:clients=32 mbgated:clients=256", 3, 3),
    Measurement("buses", "mbgated:buses=1,clients=8 mbgated:buses=4,clients=32 mbgated:buses=16,clients=128 "
                         "mbgated:buses=32,clients=256", 3, 3),
    Measurement("pipelining", "--clients 1 mbgated:outstanding=1 mbgated:outstanding=4 mbgated:outstanding=16", 3, 3),
)


def gnuplot(script):
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


HEAD = """set terminal svg size 640,360 font "sans-serif,12" background "white"
set output "{file}"
set title "{title}"
set ylabel "{ylabel}"
set yrange [{low}:{high}]
set grid y
set style data histograms
set style histogram clustered gap 1
set style fill solid 0.8 border 0
set key outside bottom horizontal
"""


def bars(folder, file, title, ylabel, columns, lines, limits=(0, "")):
    """A group of bars for each line (label, values), a colour for each column."""
    data = "\n".join('"' + label + '" ' + " ".join(f"{value:.3f}" for value in values) for label, values in lines)
    parts = [f'$data using {place + 2}:xtic(1) title "{column}"' for place, column in enumerate(columns)]
    gnuplot(f"$data << END\n{data}\nEND\n" +
            HEAD.format(file=folder / file, title=title, ylabel=ylabel, low=limits[0], high=limits[1]) +
            "plot " + ", ".join(parts) + "\n")


def plot(folder, found):
    """Each plot whose measurements are there."""
    shares = [(f"{baud} baud", found[f"share-{baud}"]) for baud in BAUDS if f"share-{baud}" in found]
    if shares:
        bars(folder, "share.svg", "Share of the wire's limit: 8 clients, 4 devices, 10 registers", "%",
             ("bare master", "mbgated"),
             [(label, [figure(c, which, "share_percent") for which in (0, 1)]) for label, c in shares], (80, 100))
    if "share-115200" in found:
        contestants = found["share-115200"]
        bars(folder, "dead-time.svg", "Time between two transactions beyond the silence, 115200 baud", "us",
             ("bare master", "mbgated"),
             [(percentile, [figure(contestants, which, f"dead_time_{percentile}_us") for which in (0, 1)])
              for percentile in ("p50", "p90", "p99")])
    speeds = [(f"{clients} clients", found[f"unpaced-{clients}"]) for clients in (8, 32) if f"unpaced-{clients}" in found]
    if speeds:
        bars(folder, "unpaced.svg", "Without a wire to wait for, no silence kept", "answers a second",
             ("fastest peer (keeps no silence)", "minimal relay", "mbgated"),
             [(label, [figure(c, which, "answers_per_second") for which in range(3)]) for label, c in speeds])
    for name, key in (("registers", "registers"), ("clients", "clients"), ("buses", "buses"),
                      ("pipelining", "outstanding")):
        if name in found:
            bars(folder, f"{name}.svg", f"Share of the wire's limit at 115200 baud, by {key}", "%", ("mbgated",),
                 [(str(one["scenario"][key]), [one["median"]["share_percent"]]) for one in found[name]], (80, 100))


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = pathlib.Path(__file__).resolve().parents[1]
    parser.add_argument("--programs", type=pathlib.Path, default=root / "build/release/bin")
    parser.add_argument("--only", default="")
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--command", action="append", default=[])
    parser.add_argument("output", type=pathlib.Path)
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    commands = dict(text.split("=", 1) for text in arguments.command)
    wanted = set(filter(None, arguments.only.split(",")))
    if unknown := wanted - {measurement.name for measurement in MEASUREMENTS}:
        sys.exit(f"figures.py: no such measurement: {', '.join(sorted(unknown))}")
    arguments.output.mkdir(parents=True, exist_ok=True)
    found = {}
    print("| figure | goal | measured | command |\n|---|---|---|---|", flush=True)
    for measurement in MEASUREMENTS:
        if (wanted and measurement.name not in wanted) or not measurement.needs() <= commands.keys():
            continue
        file = arguments.output / f"{measurement.name}.json"
        command = measurement.command(arguments.scale, commands)
        subprocess.run([arguments.programs / command[0], *command[1:], "--json", file], check=True,
                       stdout=subprocess.DEVNULL)
        found[measurement.name] = json.loads(file.read_text(encoding="utf-8"))["contestants"]
        shown = shlex.join(word for word in command if not word.startswith("--command"))
        for title, goal, value in measurement.rows:
            contestants = found[measurement.name]
            print(f"| {title} | {goal} | {value(contestants)}{faults(contestants)} | `{shown}` |", flush=True)
    if shutil.which("gnuplot"):
        plot(arguments.output, found)
    else:
        print("figures.py: no plots: gnuplot-nox is not installed", file=sys.stderr)


if __name__ == "__main__":
    main()
