"""The public names of freerock, each with the module that holds it."""

from freerock.config.campaign import load_campaign as load_campaign
from freerock.config.campaign import load_config as load_config
from freerock.config.fit_settings import FitSettings as FitSettings
from freerock.config.processing import ImpactLimits as ImpactLimits
from freerock.config.processing import RotationOptions as RotationOptions
from freerock.config.processing import RunLimits as RunLimits
from freerock.errors import FreerockError as FreerockError
from freerock.identification.fit import fit_record as fit_record
from freerock.identification.fit import fit_run as fit_run
from freerock.identification.fitted import Fit as Fit
from freerock.identification.lmfit_models import HousnerModel as HousnerModel
from freerock.identification.lmfit_models import HuntCrossleyModel as HuntCrossleyModel
from freerock.identification.lmfit_models import RockingModel as RockingModel
from freerock.identification.lmfit_models import WinklerModel as WinklerModel
from freerock.models.block import Block as Block
from freerock.models.block_on_bed import State as State
from freerock.models.ground import GroundMotion as GroundMotion
from freerock.models.ground import accelerogram as accelerogram
from freerock.models.ground import pulse as pulse
from freerock.models.laws import Rules as Rules
from freerock.models.simulate import Response as Response
from freerock.models.simulate import Solver as Solver
from freerock.models.simulate import simulate as simulate
from freerock.products.estimates import parameters_in as parameters_in
from freerock.products.netcdf import open_fits as open_fits
from freerock.products.netcdf import open_record as open_record
from freerock.records.read import list_channels as list_channels
from freerock.records.read import read_record as read_record
from freerock.rotation.flags import SignalQuality as SignalQuality
from freerock.rotation.rotation import find_rotation as find_rotation
from freerock.rotation.sensor import Laser as Laser
from freerock.rotation.view import view_of as view_of
from freerock.runs.hand_corrections import ByHand as ByHand
from freerock.runs.impacts import Impacts as Impacts
from freerock.runs.impacts import find_impacts as find_impacts
from freerock.runs.motion import Motion as Motion
from freerock.runs.runs import Run as Run
from freerock.runs.runs import find_runs as find_runs
from freerock.selection.loaded_record import LoadedRecord as LoadedRecord
from freerock.selection.loaded_record import LoadedRun as LoadedRun
from freerock.selection.loaded_record import load as load
from freerock.tables.results import open_results as open_results

__all__: list[str]
