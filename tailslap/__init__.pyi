from tailslap.api import check as check
from tailslap.api import rigid as rigid
from tailslap.api import run as run
from tailslap.api import study as study
from tailslap.campaign.sweep_run import sweep as sweep
from tailslap.comparing.compare import compare as compare
from tailslap.errors import InputError as InputError
from tailslap.exports.confirm import confirm as confirm
from tailslap.exports.export import export as export
from tailslap.modal_analysis import modes as modes
from tailslap.modal_run import modal as modal
from tailslap.replication.paper_page import paper as paper
from tailslap.result.columns import Columns as Columns
from tailslap.result.load import load as load
from tailslap.result.result import Result as Result
from tailslap.scene.read import scenes as scenes
from tailslap.scene.write import new as new
from tailslap.validation.validation_report import validate as validate
from tailslap.wall_strength.report import parapet as parapet

__version__: str
__all__: list[str]
