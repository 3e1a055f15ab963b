from tailslap.api.columns import Columns as Columns
from tailslap.api.many_runs import study as study
from tailslap.api.many_runs import sweep as sweep
from tailslap.api.one_run import check as check
from tailslap.api.one_run import rigid as rigid
from tailslap.api.one_run import run as run
from tailslap.api.plate import modal as modal
from tailslap.api.plate import modes as modes
from tailslap.api.result import Result as Result
from tailslap.api.side_by_side import compare as compare
from tailslap.errors import InputError as InputError
from tailslap.files.export import export as export
from tailslap.files.load import load as load

__version__: str
__all__: list[str]
