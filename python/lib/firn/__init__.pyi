from os import PathLike
from typing import Any, Iterator, Mapping, Protocol, Sequence, Union

import numpy as np
import numpy.typing as npt

Heights = npt.NDArray[np.float64]
Settings = Mapping[str, Union[int, float, str]]
File = Union[str, PathLike[str]]

class Print:
    drops: npt.NDArray[Any]
    reason: str
    places: npt.NDArray[Any] | None
    def __init__(self, drops: npt.ArrayLike, reason: str = ..., places: npt.ArrayLike | None = ...) -> None: ...

class End:
    reason: str
    def __init__(self, reason: str = ...) -> None: ...

class Stop:
    reason: str
    def __init__(self, reason: str = ...) -> None: ...

class Measurement:
    height_mm: Heights
    layer: int
    attempt: int
    noise_std_mm: float
    def __init__(self, height_mm: Heights, layer: int, attempt: int = ..., noise_std_mm: float = ...) -> None: ...

class Setup:
    shape: tuple[int, int]
    pitch_x_mm: float
    pitch_y_mm: float
    origin_x_mm: float
    origin_y_mm: float
    target_mm: Heights
    mask: npt.NDArray[np.bool_]
    h1_mm: float
    h2_mm: float
    h3_mm: float
    layer_height_mm: float
    seed: int
    most_drops: int
    places: npt.NDArray[np.float64]
    def predict(self, height_mm: npt.ArrayLike, drops: npt.ArrayLike, places: npt.ArrayLike | None = ...) -> Heights: ...
    def nearest_place(self, x: npt.ArrayLike, y: npt.ArrayLike) -> npt.NDArray[np.intp]: ...
    def objective_mm(self, height_mm: npt.ArrayLike) -> float: ...
    def random(self, layer: int, attempt: int = ...) -> np.random.Generator: ...

class Action:
    u: npt.NDArray[Any]
    reason: str
    def __init__(self, u: npt.ArrayLike, reason: str = ...) -> None: ...

class Model:
    h1_mm: float
    h2_mm: float
    h3_mm: float
    covariance_mm2: Union[npt.NDArray[Any], None]
    droplet_scatter: float
    def __init__(self, h1_mm: float, h2_mm: float, h3_mm: float, covariance_mm2: Union[npt.ArrayLike, None] = ...,
                 droplet_scatter: float = ...) -> None: ...

class Surface:
    height_mm: Heights
    memory: npt.NDArray[Any]
    def __init__(self, height_mm: npt.ArrayLike, memory: npt.ArrayLike = ...) -> None: ...

class Values:
    seed: int
    shape: tuple[int, int]
    pitch_x_mm: float
    pitch_y_mm: float
    origin_x_mm: float
    origin_y_mm: float
    mask: npt.NDArray[np.bool_]
    h1_mm: float
    h2_mm: float
    h3_mm: float
    droplet_mm3: float
    interval_mm: float
    low: float
    high: float
    last_layer: int
    def random(self, *numbers: int) -> np.random.Generator: ...

class Layer:
    drops: Heights
    height_mm: Heights
    learn: npt.NDArray[np.bool_]
    layer: int
    attempt: int
    noise_std_mm: float

class Landed:
    height_mm: Heights
    drops: Heights
    x_mm: Heights
    y_mm: Heights
    t_s: Heights
    vx_mm_s: Heights
    vy_mm_s: Heights
    layer: int
    memory: Heights

class Interval:
    height_mm: Heights
    material: Heights
    error: Heights
    nominal_mm: float
    layer: int
    attempt: int
    noise_std_mm: float

class ControllerClass(Protocol):
    def decide(self, measurement: Measurement) -> Union[Print, End, Stop]: ...

Controller = Union[str, type[ControllerClass]]

class FirnError(ValueError): ...

class Table:
    name: str
    def keys(self) -> list[str]: ...
    def unit(self, column: str) -> str: ...
    def about(self, column: str) -> str: ...
    def __getitem__(self, column: str) -> npt.NDArray[Any]: ...
    def __getattr__(self, column: str) -> npt.NDArray[Any]: ...
    def __len__(self) -> int: ...

class Run:
    path: PathLike[str]
    summary: dict[str, Any]
    def __init__(self, path: File) -> None: ...
    def keys(self) -> list[str]: ...
    def __getitem__(self, channel: str) -> Table: ...
    def __contains__(self, channel: str) -> bool: ...
    @property
    def maps(self) -> Table: ...
    @property
    def metrics(self) -> Table: ...
    @property
    def decisions(self) -> Table: ...
    @property
    def target_mm(self) -> Heights: ...
    @property
    def mask(self) -> npt.NDArray[np.bool_]: ...
    @property
    def experiment_toml(self) -> str: ...
    @property
    def provenance(self) -> dict[str, Any]: ...
    @property
    def result(self) -> Union[dict[str, Any], None]: ...
    @property
    def meta(self) -> dict[str, Any]: ...
    @property
    def host(self) -> Union[str, None]: ...
    @property
    def notes(self) -> list[dict[str, Any]]: ...
    @property
    def tags(self) -> list[str]: ...

def program() -> str: ...
def read_log(file: File, channel: Union[str, None] = ..., types: Union[File, None] = ...) -> Iterator[tuple[str, int, dict[str, Any]]]: ...
def decide(height_mm: npt.ArrayLike, target_mm: npt.ArrayLike, mask: Union[npt.ArrayLike, None] = ..., *, controller: Controller = ...,
           settings: Union[Settings, None] = ...) -> dict[str, Any]: ...
def simulate(experiment: File, *, controller: Union[Controller, None] = ..., seed: Union[int, None] = ...,
             settings: Union[Settings, None] = ..., runs: Union[File, None] = ...) -> Run: ...
def compare(experiment: Union[File, None], schemes: Mapping[str, Union[Controller, tuple[Controller, Settings], Sequence[Union[Run, File]]]],
            *, seeds: Union[int, Sequence[int], None] = ...,
            settings: Union[Settings, None] = ..., metrics: Union[Sequence[str], None] = ..., baseline: Union[str, None] = ...,
            threads: int = ...) -> dict[str, Any]: ...
def slice(meshes: Union[File, Sequence[File]], *, layers: Sequence[int], settings_file: Union[File, None] = ...,
          settings: Union[Settings, None] = ..., threads: int = ...) -> dict[int, list[dict[str, Any]]]: ...
def plan(points_mm: npt.ArrayLike, *, machine: File, closed: bool = ..., origin_mm: tuple[float, float] = ..., method: str = ...,
         tolerance_mm: Union[float, None] = ...) -> dict[str, Any]: ...
