"""Scores of answers: names, values in units of stated errors, honesty about causes outside the catalogue, time."""
import dataclasses
import math
import statistics

COLUMNS = ["Sort", "Sets", "Right", "by a declared tie", "False alarms, of sets with nothing", "Needless names",
           "Outside the catalogue: said so", "with a stand-in", "Values within 1, 2, 10 errors", "Error (median)",
           "Processor time (median, all)"]


# Parameters that a formula has squared alone: their sign means nothing.
EVEN = ("fall_u_per_px", "fall_v_per_px")


@dataclasses.dataclass
class Score:
    name: str
    sort: str
    course: str
    right: bool = False
    by_tie: bool = False
    missing: list = dataclasses.field(default_factory=list)
    needless: list = dataclasses.field(default_factory=list)
    honest: bool = False  # Of a cause outside the catalogue.
    deviations: list = dataclasses.field(default_factory=list)  # (effect.parameter, (value - truth) / sigma)
    failed: str = ""
    error: float = None
    cpu_s: float = None


def wilson(good, count):
    """95 % interval of a rate."""
    if count == 0:
        return 0.0, 1.0
    z = 1.959964
    rate, spread = good / count, z * z / count
    middle = (rate + spread / 2) / (1 + spread)
    half = z * math.sqrt(rate * (1 - rate) / count + spread / (4 * count)) / (1 + spread)
    return max(0.0, middle - half), min(1.0, middle + half)


def assign(truth, names):
    """What is missing, what is needless, and whether a tie that the program itself declared was needed."""
    missing, others, direct = dict(truth["hidden"]), [], {}
    for name in names:
        if name["effect"] in missing:
            del missing[name["effect"]]
            direct[name["effect"]] = name
        else:
            others.append(name)
    needless, declared = [], False
    for name in others:
        known = next((m for m in missing if name["effect"] in truth["ties"].get(m, [])), None)
        own = next((m for m in missing if m in name.get("or", [])), None)
        if known or own:
            declared |= not known
            del missing[known or own]
        elif name["effect"] not in truth["traces"] and name["effect"] not in truth["allowed"]:
            needless.append(name["effect"])
    return sorted(missing), sorted(needless), declared, direct


def deviations(truth, direct):
    found = []
    for effect, name in direct.items():
        for parameter, pair in name.get("values", {}).items():
            key, true = f"{effect}.{parameter}", truth["hidden"][effect].get(parameter)
            if true is None or key in truth["unscored"] or None in pair or not pair[1] > 0:
                continue
            off = pair[0] - true
            if parameter == "phase_rad" or parameter == "level_rad":
                off = math.remainder(off, 2 * math.pi)
            if parameter in EVEN:
                off = abs(pair[0]) - abs(true)
            found.append((key, off / pair[1]))
    return found


def score(truth, given):
    one = Score(truth["set"], truth["sort"], truth["course"])
    if given is None or given["failed"]:
        one.failed = "no answer" if given is None else given["failed"]
        one.missing = sorted(truth["hidden"])
        one.cpu_s = given and given["cpu_s"]
        return one
    one.error, one.cpu_s = given["error"], given["cpu_s"]
    one.missing, one.needless, declared, direct = assign(truth, given["names"])
    if truth["outside"]:
        one.honest = given["unexplained"]
        # Names beside an honest answer are the nearest known effects, as the program says; without it they are wrong.
        one.right = one.honest and not one.missing
        return one
    one.right = not one.missing and not one.needless and not given["unexplained"]
    one.by_tie = one.right and declared
    if not one.missing and not one.needless:
        one.deviations = deviations(truth, direct)
    return one


def scored(truths, answers):
    return [score(truth, answers.get(name)) for name, truth in sorted(truths.items())]


def rate_text(good, count):
    if count == 0:
        return "-"
    low, high = wilson(good, count)
    return f"{good} of {count} ({100 * low:.0f}-{100 * high:.0f} %)"


def row(title, some):
    null = [s for s in some if s.course == "none"]
    outside = [s for s in some if s.course == "outside"]
    off = [abs(z) for s in some for _, z in s.deviations]
    errors = [s.error for s in some if s.error is not None]
    times = [s.cpu_s for s in some if s.cpu_s is not None]
    within = ", ".join(str(sum(z <= limit for z in off)) for limit in (1, 2, 10)) + f" of {len(off)}" if off else "-"
    return [title, str(len(some)), rate_text(sum(s.right for s in some), len(some)), str(sum(s.by_tie for s in some)),
            rate_text(sum(bool(s.needless) for s in null), len(null)),
            str(sum(len(s.needless) for s in some if s.course != "outside")),
            rate_text(sum(s.honest for s in outside), len(outside)),
            str(sum(bool(s.needless) and not s.honest for s in outside)), within,
            f"{statistics.median(errors):.2f}" if errors else "-",
            f"{statistics.median(times):.1f} s, {sum(times):.0f} s" if times else "-"]


def table(scores):
    """A row a sort, and one of all."""
    sorts = list(dict.fromkeys(s.sort for s in scores))
    return [row(sort, [s for s in scores if s.sort == sort]) for sort in sorts] + [row("together", scores)]


# -- two programs on the same sets ------------------------------------------------------------------------------------

def at_least(successes, count):
    """The chance of at least so many heads of a fair coin: the exact test of McNemar on sets on which two differ."""
    return sum(math.comb(count, k) for k in range(successes, count + 1)) / 2 ** count


def pair(first, second):
    """A row a sort: sets, right by the first alone, by the second alone; p that the second is no better, no worse."""
    lines = []
    by_name = {s.name: s for s in second}
    both = [(s, by_name[s.name]) for s in first if s.name in by_name]
    for sort in [*dict.fromkeys(a.sort for a, _ in both), None]:
        some = [(a, b) for a, b in both if sort in (a.sort, None)]
        lost, won = (sum(x.right and not y.right for x, y in pairs) for pairs in (some, [(b, a) for a, b in some]))
        lines.append([sort or "together", str(len(some)), str(lost), str(won), f"{at_least(won, lost + won):.3g}",
                      f"{at_least(lost, lost + won):.3g}"])
    return lines


PAIR_COLUMNS = ["Sort", "Sets", "Right by the first alone", "by the second alone", "p: the second is no better",
                "p: the second is no worse"]
