"""Test helper: client of the standard parameter services of a node."""

from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient


class Parameters:
    """Asks the services, and waits for their answers."""

    def __init__(self, peer, node):
        self._peer = peer
        self._client = AsyncParameterClient(peer.node, node.path)
        peer.wait_for(self._client.services_are_ready, "the parameter services")

    def names(self):
        return set(self._respond(self._client.list_parameters()).result.names)

    def describe(self, *names):
        return self._respond(self._client.describe_parameters(list(names))).descriptors

    def ask(self, *names):
        """Like `get`, but gives the future of the answer."""
        return self._client.get_parameters(list(names))

    def get(self, *names):
        values = self._respond(self.ask(*names)).values
        return [parameter_value_to_python(value) for value in values]

    def set(self, **values):
        return self._respond(self.request(**values)).results

    def request(self, **values):
        """Like `set`, but gives the future of the answer."""
        return self._client.set_parameters([Parameter(name, value=value) for name, value in values.items()])

    def succeed(self, **values):
        for result in self.set(**values):
            assert result.successful, result.reason

    def set_atomically(self, **values):
        parameters = [Parameter(name, value=value) for name, value in values.items()]
        return self._respond(self._client.set_parameters_atomically(parameters)).result

    def _respond(self, future):
        return self._peer.result(future, "an answer of the parameter services")
