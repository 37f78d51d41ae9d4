"""Baselines beside SEAM: what knows all, what knows nothing, and plain methods over a library of linear terms."""
import math

import numpy as np

import library
import library_logs
from answers import answer

PROBLEMS = {"boards": library.of_boards, "videos": library.of_boards, "landmarks": library_logs.of_landmarks,
            "walks": library_logs.of_walks, "wheels": library_logs.of_walks, "servos": library_logs.of_servos,
            "motors": library_logs.of_servos, "flats": library_logs.of_flats}
# Log evidence that a smooth function must gain over white noise.
FIELD_GAIN = 10.0
FIELD_ROWS = 500


def oracle(_, truth):
    """Knows the truth, with errors of nothing: what a perfect program scores."""
    names = [{"effect": effect, "or": [], "values": {key: [v, abs(v) * 1e-5 + 1e-9] for key, v in values.items()}}
             for effect, values in truth["hidden"].items()]
    return answer(names, bool(truth["outside"]), 1.0)


def nothing(_, __):
    """Names nothing and finds all explained."""
    return answer()


# -- over a library of terms ------------------------------------------------------------------------------------------

def problem_in(folder):
    """Without the nuisance: residuals and columns that are orthogonal to it."""
    problem = PROBLEMS[folder.name.rsplit("-", 1)[0]](folder)
    if problem is None:
        return None
    base = np.linalg.qr(problem.nuisance[:, np.any(problem.nuisance != 0, 0)])[0]
    problem.y = problem.y - base @ (base.T @ problem.y)
    problem.terms = [(effect, others, names, columns - base @ (base.T @ columns))
                     for effect, others, names, columns in problem.terms]
    return problem


def criterion(problem, rss, count):
    """Bayes' information criterion, of known noise or of noise that is fitted."""
    n = len(problem.y)
    return (rss if problem.stated else n * math.log(max(rss, 1e-300) / n)) + count * math.log(n)


def fitted(problem, chosen):
    """Sum of squares, values and their standard errors with some of the terms."""
    if not chosen:
        return float(problem.y @ problem.y), np.zeros(0), np.zeros(0)
    a = np.concatenate([problem.terms[k][3] for k in chosen], axis=1)
    values = np.linalg.lstsq(a, problem.y, rcond=None)[0]
    left = problem.y - a @ values
    rss = float(left @ left)
    noise = 1.0 if problem.stated else rss / max(1, len(problem.y) - a.shape[1])
    return rss, values, np.sqrt(noise * np.maximum(np.diag(np.linalg.pinv(a.T @ a)), 0))


def answer_of(problem, chosen):
    """Terms as names; several terms of one effect are one name."""
    rss, values, sigmas = fitted(problem, chosen)
    names, at = {}, 0
    for k in chosen:
        effect, others, parameters, columns = problem.terms[k]
        given = {name: [float(values[at + i]), float(sigmas[at + i])] for i, name in enumerate(parameters)}
        names.setdefault(effect, {"effect": effect, "or": list(others), "values": given})
        at += columns.shape[1]
    return answer(names.values(), False, math.sqrt(rss / len(problem.y)))


def best_terms(problem):
    """Adds the term that lowers Bayes' criterion most, and removes terms while that lowers it."""
    sizes = [columns.shape[1] for *_, columns in problem.terms]

    def cost(chosen):
        return criterion(problem, fitted(problem, chosen)[0], sum(sizes[k] for k in chosen))
    chosen, best = [], cost([])
    while True:
        moves = [chosen + [k] for k in range(len(sizes)) if k not in chosen]
        moves += [[k for k in chosen if k != gone] for gone in chosen]
        costs = [cost(move) for move in moves]
        if not costs or min(costs) >= best - 1e-9:
            return chosen
        best, chosen = min(costs), moves[int(np.argmin(costs))]


def stepwise(folder, _):
    problem = problem_in(folder)
    return problem and answer_of(problem, best_terms(problem))


def lasso(folder, _):
    """Least squares with a penalty on absolute values, by coordinate descent. The penalty is chosen by Bayes' criterion
    of the terms that it keeps, fitted again without it. Names are the terms with any number that is not zero."""
    problem = problem_in(folder)
    if problem is None:
        return None
    whole = np.concatenate([columns for *_, columns in problem.terms], axis=1)
    owner = np.concatenate([[k] * columns.shape[1] for k, (*_, columns) in enumerate(problem.terms)])
    length = np.linalg.norm(whole, axis=0)
    a = whole / np.where(length > 0, length, 1)
    gram, right = a.T @ a, a.T @ problem.y
    values, best = np.zeros(a.shape[1]), (criterion(problem, float(problem.y @ problem.y), 0), [])
    for penalty in np.max(np.abs(right)) * np.geomspace(0.95, 1e-4, 40):
        for _ in range(500):
            before = values.copy()
            for j in range(len(values)):
                slope = right[j] - gram[j] @ values + gram[j, j] * values[j]
                values[j] = math.copysign(max(abs(slope) - penalty, 0.0), slope) / max(gram[j, j], 1e-12)
            if np.max(np.abs(values - before)) < 1e-6 * np.max(np.abs(values) + 1e-12):
                break
        chosen = sorted(set(owner[values != 0].tolist()))
        count = sum(problem.terms[k][3].shape[1] for k in chosen)
        best = min(best, (criterion(problem, fitted(problem, chosen)[0], count), chosen))
    return answer_of(problem, best[1])


def field_gain(problem):
    """Log evidence that a smooth function of what residuals may depend on gains over white noise."""
    some = np.unique(np.linspace(0, len(problem.y) - 1, FIELD_ROWS).astype(int))
    y = problem.y[some]
    fields = {name: values[some] for name, values in problem.fields.items()}
    channel = fields.pop("channel", np.zeros(len(some)))
    same = channel[:, None] == channel[None, :]
    noise = 1.0 if problem.stated else float(np.mean(y * y))
    plain = -0.5 * (y @ y / noise + len(y) * math.log(noise))
    best = plain
    scaled = {name: (values - values.mean()) / (values.std() + 1e-12) for name, values in fields.items()}
    whole = np.stack(list(scaled.values()), -1)
    for x in (*[values[:, None] for values in scaled.values()], whole):
        apart = np.sum((x[:, None] - x[None, :]) ** 2, -1)
        for length in (0.3, 1.0):
            basis = np.exp(-0.5 * apart / length ** 2) * same
            for share in (0.03, 0.3, 3.0):
                # The function's variance over that of the noise; without a stated noise both follow the residuals.
                root = np.linalg.cholesky(share * basis + np.eye(len(y)))
                z = np.linalg.solve(root, y)
                scale = noise if problem.stated else float(z @ z) / len(y)
                evidence = -0.5 * (z @ z / scale + len(y) * math.log(scale)) - np.sum(np.log(np.diag(root)))
                best = max(best, float(evidence))
    return float(best - plain)


def gaussian_process(folder, _):
    """Names by `stepwise`; something is unexplained where a smooth function of what they leave has evidence."""
    problem = problem_in(folder)
    if problem is None:
        return None
    chosen = best_terms(problem)
    given = answer_of(problem, chosen)
    if chosen:
        _, values, _ = fitted(problem, chosen)
        problem.y = problem.y - np.concatenate([problem.terms[k][3] for k in chosen], axis=1) @ values
    return given | {"unexplained": field_gain(problem) > FIELD_GAIN}


BASELINES = {"oracle": oracle, "nothing": nothing, "stepwise": stepwise, "lasso": lasso,
             "gaussian_process": gaussian_process}
