"""Test helper: evaluates launch files by stand-ins for `launch` and `launch_ros`, whose wheels are not on PyPI.

What they make of a file is the command line that launch_ros starts: program, arguments, then --ros-args with name,
namespace, parameters as files, remaps.
"""

import importlib.util
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from unittest.mock import patch

import yaml

from node_process import BINARY, ROOT, yaml_text


@dataclass
class Argument:
    name: str
    default_value: str
    description: str


@dataclass
class OpaqueFunction:
    function: object


@dataclass
class Include:
    """Another of our files, with arguments."""

    source: str
    launch_arguments: object

    def nodes(self):
        return LaunchFile(Path(self.source).name).nodes(**dict(self.launch_arguments))


@dataclass
class Substitution:
    name: str

    def perform(self, context):
        return context[self.name]


@dataclass
class ParameterValue:
    value: str
    value_type: type


@dataclass
class Node:
    executable: str
    package: str = None
    name: str = None
    namespace: str = ""
    arguments: list = field(default_factory=list)
    parameters: list = field(default_factory=list)
    remappings: list = field(default_factory=list)
    output: str = "log"
    respawn: bool = False
    respawn_delay: float = 0.0  # [s]

    def __post_init__(self):
        """A parameter is read as YAML, if nobody says that it is a text."""
        values = [value for given in self.parameters if isinstance(given, dict) for value in given.values()]
        assert all(yaml.safe_load(value) for value in values if isinstance(value, str))

    def ros_arguments(self, folder):
        """What follows --ros-args."""
        words = []
        if self.name:
            words += ["-r", f"__node:={self.name}"]
        if self.namespace:
            words += ["-r", f"__ns:={self.namespace if self.namespace.startswith('/') else '/' + self.namespace}"]
        for number, parameters in enumerate(self.parameters):
            file = parameters
            if isinstance(parameters, dict):
                lines = [f"    {name}: {yaml_text(value)}" for name, value in parameters.items()]
                file = folder / f"launch_params_{number}.yaml"
                file.write_text("/**:\n  ros__parameters:\n" + "\n".join(lines) + "\n")
            words += ["--params-file", str(file)]
        for before, after in self.remappings:
            words += ["-r", f"{before}:={after}"]
        return words

    def command(self, folder):
        program = self.executable if self.package is None else f"{self.package}/{self.executable}"
        return [program, *self.arguments, "--ros-args", *self.ros_arguments(folder)]


def _modules():
    launch, actions, sources, substitutions = (
        ModuleType(f"launch{part}") for part in ("", ".actions", ".launch_description_sources", ".substitutions")
    )
    launch_ros, ros_actions, descriptions = (
        ModuleType(f"launch_ros{part}") for part in ("", ".actions", ".parameter_descriptions")
    )
    launch.LaunchDescription = list
    actions.DeclareLaunchArgument, actions.OpaqueFunction = Argument, OpaqueFunction
    actions.IncludeLaunchDescription, sources.PythonLaunchDescriptionSource = Include, str
    substitutions.LaunchConfiguration = Substitution
    ros_actions.Node, descriptions.ParameterValue = Node, ParameterValue
    modules = launch, actions, sources, substitutions, launch_ros, ros_actions, descriptions
    return {module.__name__: module for module in modules}


FILES = sorted(path.name for path in (ROOT / "launch_scripts").glob("*.launch.py"))


class LaunchFile:
    def __init__(self, name):
        path = ROOT / "launch_scripts" / name
        specification = importlib.util.spec_from_file_location(Path(name).stem.replace(".", "_"), path)
        module = importlib.util.module_from_spec(specification)
        with patch.dict(sys.modules, _modules()), patch.object(sys, "dont_write_bytecode", True):
            specification.loader.exec_module(module)
            entities = module.generate_launch_description()
        self.arguments = {entity.name: entity for entity in entities if isinstance(entity, Argument)}
        self._functions = [entity.function for entity in entities if isinstance(entity, OpaqueFunction)]

    def nodes(self, **given):
        """The nodes that it starts with these arguments; each must be declared."""
        assert given.keys() <= self.arguments.keys()
        context = {name: str(given.get(name, argument.default_value)) for name, argument in self.arguments.items()}
        entities = [entity for function in self._functions for entity in function(context)]
        return [node for entity in entities for node in (entity.nodes() if isinstance(entity, Include) else [entity])]

    def command(self, folder, **given):
        """The command line of its one node of ours, with the binary under test."""
        (command,) = self.commands(folder, **given)
        return command

    def commands(self, folder, **given):
        """Those of all its nodes of ours."""
        nodes = [node for node in self.nodes(executable=BINARY, **given) if node.executable == BINARY]
        assert all(node.package is None for node in nodes)
        folders = [folder / str(number) for number in range(len(nodes))]
        for one in folders:
            one.mkdir()
        return [node.command(one) for node, one in zip(nodes, folders, strict=True)]
