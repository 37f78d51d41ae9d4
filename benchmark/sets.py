"""What a generator makes, and how it is written: a folder in SEAM's format, and the truth outside that folder."""
import dataclasses
import json
import math
import pathlib
import struct
import zlib

import numpy as np

import outside

# What is hidden in a set, by its number: ten numbers in a row have each case.
COURSE = ("none", "one", "two", "three", "tie", "trace", "outside", "gross", "none", "outside")
HIDDEN_COUNT = {"none": 0, "one": 1, "two": 2, "three": 3, "tie": 1, "trace": 1, "outside": 0, "gross": 1}
GROSS_SHARE = 0.01
# Noise units, root mean square over the observations.
TRACE_SIZE = 0.03
TIE_SIZE = 0.1


@dataclasses.dataclass
class Plan:
    """What is asked of a generator. A sort with an effect (`servos+gear_ripple`) hides that one effect in its odd numbers
    and nothing in the even ones; a sort with a cause outside the catalogue (`servos+floor_shakes`) hides it in each."""
    sort: str
    number: int

    @property
    def base(self):
        return self.sort.partition("+")[0]

    @property
    def cause(self):
        return self.sort.partition("+")[2]

    def strange(self, possible):
        """The cause outside the catalogue: the sort's own, or these in turn."""
        if self.course != "outside":
            return ""
        return outside.cause_of(self.sort) or possible[self.turn % len(possible)]

    @property
    def course(self):
        if outside.cause_of(self.sort):
            return "outside"
        return ("none", "one")[self.number % 2] if self.cause else COURSE[self.number % len(COURSE)]

    def names(self, draw, possible):
        """The effects to hide: the sort's own cause, or as many of these as the number says."""
        if self.cause:
            return [self.cause][:self.count]  # None beside a cause outside the catalogue.
        return draw.sample(possible, self.count)

    @property
    def count(self):
        return HIDDEN_COUNT[self.course]

    @property
    def turn(self):
        """How many sets with this case come before: generators take their variants in turn by it."""
        rounds, at = divmod(self.number, len(COURSE))
        return rounds * COURSE.count(self.course) + COURSE[:at].count(self.course)

    @property
    def gross(self):
        return GROSS_SHARE if self.course == "gross" else 0.0

    @property
    def name(self):
        return f"{self.sort}-{self.number:04}"


@dataclasses.dataclass(frozen=True)
class Free:
    """A value of a model that is fitted with it."""
    value: float


@dataclasses.dataclass
class MadeSet:
    kind: str
    settings: str  # Further lines of measurement.yaml.
    tables: dict  # File: lines.
    nominal: dict  # Effect: parameters.
    hidden: dict = dataclasses.field(default_factory=dict)
    nuisance: dict = dataclasses.field(default_factory=dict)  # True values of what is free in the nominal model.
    ties: dict = dataclasses.field(default_factory=dict)  # Hidden effect: names that stand for it.
    traces: dict = dataclasses.field(default_factory=dict)
    allowed: list = dataclasses.field(default_factory=list)  # Names that are neither needed nor needless.
    outside: str = ""  # A cause in no catalogue.
    unscored: list = dataclasses.field(default_factory=list)  # effect.parameter that the data do not constrain.
    images: dict = dataclasses.field(default_factory=dict)
    noise_stated: bool = True


def number_text(value):
    if isinstance(value, Free):
        return f"{{value: {value.value:.9g}, free: true}}"
    return f"{value:.9g}"


def model_text(name, effects):
    lines = [f"  {effect}: {{{', '.join(f'{key}: {number_text(value)}' for key, value in values.items())}}}"
             for effect, values in effects.items()]
    return f"format: seam-model/1\nname: {name}\neffects:" + (" {}" if not lines else "") + "\n" + "".join(f"{line}\n" for line in lines)


def rows(header, formats, *columns):
    """Lines of a table; a cell that is not finite stays blank."""
    lines = [header]
    for cells in zip(*columns):
        lines.append(",".join("" if isinstance(cell, float) and not math.isfinite(cell) else format(cell, form)
                              for cell, form in zip(cells, formats)))
    return lines


def noise_line(stated, **sigmas):
    if not stated:
        return ""
    return "noise: {" + ", ".join(f"{name}: {sigma:.6g}" for name, sigma in sigmas.items()) + "}\n"


def png16(values):
    """A grey image of 16 bits."""
    height, width = values.shape
    body = np.zeros((height, 1 + 2 * width), dtype=np.uint8)
    body[:, 1:] = values.astype(">u2").view(np.uint8).reshape(height, 2 * width)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(body.tobytes(), 6)) + chunk(b"IEND", b""))


def write(made, plan, out):
    """OUT/sets/NAME is what a program gets; OUT/truth/NAME.json and .yaml are not."""
    folder, truth = pathlib.Path(out) / "sets" / plan.name, pathlib.Path(out) / "truth"
    folder.mkdir(parents=True, exist_ok=True)
    truth.mkdir(parents=True, exist_ok=True)
    for name, lines in made.tables.items():
        (folder / name).write_text("\n".join(lines) + "\n")
    for name, image in made.images.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(png16(image))
    (folder / "measurement.yaml").write_text(
        f"format: seam-measurement/1\nkind: {made.kind}\ntitle: {plan.name}\n{made.settings}")
    (folder / "nominal.yaml").write_text(model_text("nominal", made.nominal))
    model = dict(made.nominal)
    # An ideal part gives way to the one that acts.
    for effect in made.hidden:
        model.pop({"motor_servo": "ideal_servo"}.get(effect, ""), None)
    (truth / f"{plan.name}.yaml").write_text(model_text("truth", model | made.nuisance | made.hidden | made.traces))
    (truth / f"{plan.name}.json").write_text(json.dumps({
        "format": "seam-truth/1", "set": plan.name, "sort": plan.sort, "kind": made.kind,
        "course": "one" if plan.course == "outside" and not made.outside else plan.course,
        "hidden": made.hidden, "ties": made.ties, "traces": made.traces, "allowed": made.allowed,
        "outside": made.outside or None,
        "depends_on": outside.DEPENDS_ON.get(plan.base, {}).get(made.outside, ()), "unscored": made.unscored, "noise_stated": made.noise_stated,
        "gross_share": plan.gross}, indent=1) + "\n")
    return folder


def read_truths(out):
    """Truths of a folder by the names of their sets."""
    found = {}
    for path in sorted((pathlib.Path(out) / "truth").glob("*.json")):
        truth = json.loads(path.read_text())
        found[truth["set"]] = truth
    return found
