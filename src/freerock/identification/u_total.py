"""u_total of the numbers of a fit: by noise, scatter of the impacts, inputs and the error of the law."""

from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.identification.posterior import Posterior
from freerock.runs.u_of_measured import Contributions


@dataclass(frozen=True)
class Uncertainty:
    """What is known of the numbers of a fit.

    Parameters
    ----------
    covariance : ndarray, shape (n_parameters, n_parameters)
        In the product of the parameters' units: noise, inputs, scatter of the impacts, error of the law.
    stderr : ndarray, shape (n_parameters,)
        Standard uncertainty by noise and scatter of the impacts.
    u_law : ndarray, shape (n_parameters,)
        What a residual beyond the noise adds to it.
    contributions : Contributions
        Of the inputs of the laboratory.
    """

    covariance: Floats
    stderr: Floats
    u_law: Floats
    contributions: Contributions

    @property
    def u_total(self) -> Floats:
        """Standard uncertainty by all of it, shape (n_parameters,)."""
        of_inputs = np.sum(self.contributions.values**2, axis=1)
        return np.asarray(np.sqrt(self.stderr**2 + self.u_law**2 + of_inputs))


def uncertainty_of(posterior: Posterior) -> tuple[Uncertainty, Floats]:
    """What is known of the numbers of a fit, and the covariance of all it has, shape (n_all, n_all)."""
    model, n, contributions = posterior.posed.model, posterior.n_names, posterior.contributions()
    plain, whole = np.diag(posterior.inverse)[:n], np.diag(posterior.covariance)[:n]
    moved = [contributions.inputs.index(each) for each in model.inputs]
    by_moved = np.sum(contributions.values[:, moved] ** 2, axis=1)
    stderr = np.sqrt(np.maximum(np.minimum(plain, whole) - by_moved, 0.0))
    # where a search of a law that is far off ends early, its numbers have a step ahead of them
    u_law = np.sqrt(np.maximum(whole - np.minimum(plain, whole), 0.0) + posterior.step[:n] ** 2)
    covariance = posterior.covariance + np.outer(posterior.step, posterior.step)
    beside = [j for j in range(len(contributions.inputs)) if j not in moved]
    covariance[:n, :n] += contributions.values[:, beside] @ contributions.values[:, beside].T
    of_moved = contributions.values[:, moved]
    covariance[:n, :n] += (posterior.birge**2 - 1) * of_moved @ of_moved.T
    contributions.values[:, moved] *= posterior.birge
    return Uncertainty(covariance[:n, :n], stderr, u_law, contributions), covariance
