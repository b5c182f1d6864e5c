"""Channels of a run as tables of other packages and programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from kanefe._version import __version__
from kanefe.arguments import checked
from kanefe.results.reader import Reader
from kanefe.results.table_files import write_csv, write_matlab
from kanefe.results.tables import channels_of

if TYPE_CHECKING:
    from kanefe.scene.targets import Named


class TableReader(Reader):
    """The tables of `kanefe.Result`."""

    @checked("channels")
    def to_dataframe(self, channels: Named | None = None) -> Any:
        """Return channels over the output times as a ``pandas.DataFrame``; its ``attrs["units"]`` has their units.

        Parameters
        ----------
        channels : str, sequence or mapping of str, optional
            A quantity, the body (or load, loop or contact) and its interface, and one component if not all are wanted:
            ``"position arm/tip"``, ``"joint_reaction hub force_x"``, ``"kinetic_energy"``. Quantities are those of
            `units`. A mapping gives names of your own. Default: coordinates and speeds of joints and modes.

        Returns
        -------
        pandas.DataFrame
            One row for each output time; the index is "time", in s.

        Raises
        ------
        ModelError
            If there is no such channel; the message lists what there is.
        MissingDependency
            If pandas is not installed.

        Examples
        --------
        ``result.to_dataframe({"tip": "position arm/tip y"})["tip"].plot()``
        """
        from kanefe.storage._pandas import frame_of

        found = channels_of(self, channels)
        columns: dict[str, Any] = {name: values for channel in found for name, _, values in channel.each()}
        units = {name: unit for channel in found for name, unit, _ in channel.each()}
        return frame_of({"time": self.times} | columns, "time", units)

    @checked("channels")
    def to_xarray(self, channels: Named | None = None) -> Any:
        """Return channels over the output times as an ``xarray.Dataset``; each variable has the attribute "units".

        Names are such that netCDF and zarr take them: "/" is ".", and the attribute "long_name" is what was changed.

        Parameters and errors: `to_dataframe`; it needs xarray.

        Examples
        --------
        ``result.to_xarray("position arm/tip")["position arm.tip y"].sel(time=1.0, method="nearest")``
        """
        from kanefe.storage._xarray import data_set_of

        variables = {
            name: ("time", values.copy(), {"units": unit})
            for channel in channels_of(self, channels)
            for name, unit, values in channel.each()
        }
        about = {"kanefe": __version__, "status": str(self.status)}
        return data_set_of(variables, {"time": ("time", self.times.copy(), {"units": "s"})}, about)

    @checked("path", "channels")
    def to_csv(self, path: str | Path, channels: Named | None = None) -> Path:
        """Write channels over the output times as comma-separated text, with units in the first line.

        Parameters
        ----------
        path : path
            Ends in .csv; its folder is created.
        channels : str, sequence or mapping of str, optional
            See `to_dataframe`.

        Raises
        ------
        ModelError, FileError
            If there is no such channel, or the file cannot be written.

        Examples
        --------
        ``result.to_csv("out/tip.csv", ["position arm/tip", "joint_reaction hub"])``
        """
        return write_csv(self.times, channels_of(self, channels), path)

    @checked("path", "channels")
    def to_matlab(self, path: str | Path, channels: Named | None = None) -> Path:
        """Write channels over the output times as a MAT file: `time`, a matrix for each channel, `columns`, `units`.

        Parameters
        ----------
        path : path
            Ends in .mat; its folder is created.
        channels : str, sequence or mapping of str, optional
            See `to_dataframe`. In MATLAB ``position arm/tip`` is ``position_arm_tip``; keywords are no names.

        Raises
        ------
        ModelError, FileError
            If there is no such channel, two have the same name in MATLAB, or the file cannot be written.

        Examples
        --------
        ``result.to_matlab("out/run.mat", {"tip": "position arm/tip", "load": "coupling_force arm/root"})``
        """
        return write_matlab(self.times, channels_of(self, channels), path)
