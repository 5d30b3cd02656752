"""Made-up choices: rows of the tidy tables choice and parameters for one scene."""

import pandas as pd

from freerock.columns import columns_of
from freerock.models.free_parameters import unit_of
from freerock.models.laws import CANDIDATES, MODELS, law_of
from freerock.selection.allowed_hypotheses import NOT_TRIED

NAMED, POSSIBLE, REJECTED, NOT_FITTED = "selected", "also_possible", "rejected", "not_fitted"
VALUES = {"r": 0.95, "k": 6.88e6, "c": 2.36e4, "lambda": 1.3e8, "width": 0.063}
WHERE = {"campaign": "made_up", "test": "t1", "block": "b1", "foundation": "marble"}


def n_freed(model):
    return len(MODELS[model]) + CANDIDATES[model].width + 2


def scene(*runs, explained=True, epsilon=1e-5, **changed):
    """Tables of the statuses of each run by candidate; others were not fitted, those that free more than one
    that explains the run not tried. Values may be changed by name, or by name and candidate as
    k_winkler_pivoting."""
    choice, parameters = [], []
    for number, statuses in enumerate(runs, 1):
        enough = min((n_freed(m) for m in statuses if explained and statuses[m] == NAMED), default=99)
        for rank, model in enumerate(CANDIDATES):
            status = statuses.get(model, NOT_FITTED)
            fitted, named = status != NOT_FITTED, status in (NAMED, POSSIBLE)
            row = WHERE | {
                "run": number,
                "model": model,
                "status": status,
                "n_freed": n_freed(model),
            }
            row |= {"explains": named and explained, "reason": f"{status} {model}"}
            if status == NOT_FITTED and n_freed(model) > enough:
                row |= {"reason": f"{NOT_TRIED}a smaller candidate explains the run"}
            if fitted:
                row |= {"epsilon_theta": epsilon, "epsilon_holdout": 2 * epsilon, "bic": 10.0 * rank}
                row |= {"noise_p": 0.5 if named else 1e-8, "noise_ratio": 0.9 if named else 30.0}
                row |= {"noise_low_hz": 1.0, "noise_high_hz": 2.0}
                names = (*MODELS[model], *(["width"] if CANDIDATES[model].width else []))
                parameters += [
                    WHERE
                    | {
                        "run": number,
                        "model": model,
                        "parameter": name,
                        "unit": unit_of(name),
                        "success": True,
                    }
                    | {"value": changed.get(f"{name}_{model}", changed.get(name, VALUES[name]))}
                    for name in names
                ]
            choice.append(row)
    frame = pd.DataFrame(choice, columns=columns_of("choice")).astype({"explains": bool, "n_freed": "Int64"})
    return frame, pd.DataFrame(parameters, columns=columns_of("parameters")).astype({"success": bool})


def paper(status=REJECTED, **others):
    """Statuses of the paper's models, and of others."""
    return dict.fromkeys(("housner", "winkler", "hunt_crossley"), status) | others


PIVOTING = [m for m, each in CANDIDATES.items() if each.kinematics == "pivoting" and law_of(m).is_foundation]
