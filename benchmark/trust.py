"""How far a verdict can be trusted: of sets of a kind whose answers looked alike, how many were right."""
import scores

ENDS = ("nothing", "named", "unexplained")
HEAD = """// How often verdicts were right on sets of the benchmark, by kind and verdict. Made by
// `benchmark/run.py trust` from answers to sets of all sorts and to those of `outside`.
#pragma once

namespace seam::measurement {

struct TrustRow {
  const char* kind;
  const char* verdict;  // nothing, named, unexplained
  int sets, right;
};

"""


def end_of(given):
    """How an answer ended: what was found does not count where something is left unexplained."""
    if given["unexplained"]:
        return "unexplained"
    return "named" if given["names"] else "nothing"


def counts(truths, answers):
    """{(kind, end): [sets, right]} of the sets that have an answer."""
    found = {}
    for name, truth in sorted(truths.items()):
        given = answers.get(name)
        if given is None or given["failed"]:
            continue
        count = found.setdefault((truth["kind"], end_of(given)), [0, 0])
        count[0] += 1
        count[1] += scores.score(truth, given).right
    return found


def header(found):
    kinds = sorted({kind for kind, _ in found})
    rows = [f'    {{"{kind}", "{end}", {found[kind, end][0]}, {found[kind, end][1]}}},'
            for kind in kinds for end in ENDS if (kind, end) in found]
    return HEAD + "inline constexpr TrustRow kTrust[] = {\n" + "\n".join(rows) + "\n};\n\n}  // namespace seam::measurement\n"
