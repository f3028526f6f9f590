"""The channels of a running simulation, for Catalyst scripts."""
from paraview.catalyst.detail import CreateProducer
from paraview.modules.vtkPVPythonCatalyst import vtkCPPythonScriptV2Helper

_producers = {}


def channels():
    """Names of the channels that there are at this step: points, domains, grid, walls, rve_NAME_discs, rve_NAME_contacts."""
    description = vtkCPPythonScriptV2Helper.GetActiveInstance().GetDataDescription()
    return [description.GetInputDescriptionName(i) for i in range(description.GetNumberOfInputDescriptions())]


def producers():
    """ParaView's source of each channel that there is now.  RVEs may come while a run is on."""
    script = vtkCPPythonScriptV2Helper.GetActiveInstance().GetScriptFileName()
    for name in channels():
        if (script, name) not in _producers:
            _producers[script, name] = CreateProducer(name)
    return {name: _producers[script, name] for name in channels()}


def rves(names):
    """NAMEs among channels rve_NAME_discs."""
    return sorted(name[len("rve_"):-len("_discs")] for name in names if name.startswith("rve_") and name.endswith("_discs"))
