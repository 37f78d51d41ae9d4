"""Causes outside the catalogue: what a program says of them, and what it should not say."""
import re

import scores

# A formula is right that leaves no more than this of the noise on held-out groups.
MOST_LEFT = 1.1
COLUMNS = ["Sort", "Sets", "Said so, and on what it depends", "Said so", "A formula that leaves nothing",
           "No name that stands in"]


def stand_ins(given):
    """Names that are said to be missing: what is said to come nearest, or to be noise of unknown cause, is a hint."""
    return [name["effect"] for name in given["names"] if not name.get("hint")]


def is_named(right, name):
    """Whether all words of the right quantity stand in the one that was named."""
    return set(re.findall(r"\w+", right)) <= set(re.findall(r"\w+", name))


def judged(truth, given):
    """(said so and on what, said so, formula right, no stand-in)"""
    if given is None or given["failed"]:
        return False, False, False, False
    said = given["unexplained"]
    on_what = any(is_named(right, name) for name in given.get("depends_on", ()) for right in truth["depends_on"])
    left = given.get("formula_error")
    return said and on_what, said, said and left is not None and left < MOST_LEFT, not stand_ins(given)


def row(title, some):
    return [title, str(len(some))] + [scores.rate_text(sum(column), len(some)) for column in zip(*some)]


def table(truths, answers):
    all_judged = {name: judged(truth, answers.get(name)) for name, truth in sorted(truths.items())}
    sorts = dict.fromkeys(truth["sort"].partition("+")[0] for truth in truths.values())
    lines = [row(sort, [one for name, one in all_judged.items() if truths[name]["sort"].partition("+")[0] == sort])
             for sort in sorts]
    return lines + [row("together", list(all_judged.values()))]


def wrong(truths, answers):
    for name, truth in sorted(truths.items()):
        given = answers.get(name)
        whole, said, formula, alone = judged(truth, given)
        if whole and alone:
            continue
        given = given or {"failed": "no answer", "names": [], "error": None}
        yield (f"{name:28} {'said' if said else 'NOT SAID'} {'' if whole else 'not on what it depends'} "
               f"names {' '.join(stand_ins(given)) or '-'}; depends on {', '.join(given.get('depends_on', [])) or '-'}; "
               f"error {given['error']} {given['failed'] or ''}")
