"""Tests of the view in a web browser by HTTP requests: page, sliders, states and rejected requests."""

import json
import math
import os
import urllib.error
import urllib.request

import numpy as np
import pytest

import clearance as cl


def request(url, content=None, **headers):
    data = None if content is None else json.dumps(content).encode()
    headers = {"Content-Type": "application/json", **headers} if data else headers
    with urllib.request.urlopen(urllib.request.Request(url, data, headers), timeout=60) as response:
        return response.read()


def update(view):
    """What the page receives first."""
    with urllib.request.urlopen(view.url + "updates", timeout=60) as stream:
        for line in stream:
            if line.startswith(b"data: "):
                return json.loads(line[len("data: ") :])
    raise AssertionError("the stream ended without an update")


def rejection(*arguments, **headers):
    """The HTTP status of the error."""
    with pytest.raises(urllib.error.HTTPError) as error:
        request(*arguments, **headers)
    error.value.close()
    return error.value.code


def test_the_page_and_its_sliders(arm, home):
    with arm.view(home) as view:
        assert view.url.startswith("http://127.0.0.1:")
        assert b"<html" in request(view.url)
        sliders = json.loads(request(view.url + "joints"))
        assert [s["name"] for s in sliders] == arm.joint_names
        assert np.allclose([s["lower"] for s in sliders], arm.lower)
        assert np.allclose([s["upper"] for s in sliders], arm.upper)
        assert all(s["unit"] == "rad" for s in sliders)
        assert request(view.url + "robot") and request(view.url + "world")


def test_a_slider_changes_the_distance(arm, home):
    with arm.view(home) as view:
        first = update(view)
        assert first["status"] == "FREE" and np.array_equal(first["sliders"], home)
        near = arm.distance(home, 1.0)
        assert math.isclose(first["world_nearest"]["pair"]["distance"], near.world_distance, abs_tol=1e-9)
        request(view.url + "state", {"joint": arm.joint_names[1], "position": home[1] + 0.3})
        moved = home.copy()
        moved[1] += 0.3
        assert np.array_equal(view.state, moved)
        second = update(view)
        assert second["world_nearest"]["pair"]["distance"] != first["world_nearest"]["pair"]["distance"]
        assert np.array_equal(second["sliders"], moved)


def test_set_state(arm, home, robot, states):
    colliding = next(q for q in states[:, :7] if not arm.is_free(q))
    with arm.view() as view:
        assert np.array_equal(view.state, arm.configuration())
        view.set_state(colliding)
        shown = update(view)
        assert shown["status"] == "COLLIDING" and len(shown["colliding"]) == len(arm.check(colliding).pairs)
        view.set_state(home)
        assert update(view)["status"] == "FREE"
        for bad in ([1.0], np.full(7, np.nan)):
            with pytest.raises(ValueError, match="q"):
                view.set_state(bad)
        assert np.array_equal(view.state, home)


def test_requests_are_validated(arm, home):
    with arm.view(home) as view:
        name = arm.joint_names[0]
        for bad in ({}, {"joint": "none", "position": 0.0}, {"joint": name, "position": 1e3}, {"joint": name, "position": "1"}, []):
            assert rejection(view.url + "state", bad) == 400
        good = {"joint": name, "position": 0.1}
        assert rejection(view.url + "state", good, Origin="http://evil.example") == 403
        assert rejection(view.url + "state", good, Host="evil.example") == 421
        assert rejection(view.url + "updates", Host="evil.example") == 421
        assert np.array_equal(view.state, home)


def test_a_closed_view(arm):
    view = arm.view()
    assert view.url in view._repr_html_() and "closed" not in repr(view)
    view.close()
    view.close()
    assert "closed" in repr(view)
    with pytest.raises(urllib.error.URLError):
        request(view.url)
    with pytest.raises(cl.Error, match="closed"):
        view.set_state(arm.configuration())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_forked_process_leaves_the_view_alone(arm, home):
    with arm.view(home) as view:
        child = os.fork()
        if child == 0:
            try:
                with pytest.raises(cl.Error, match="process"):
                    view.set_state(home)
                assert view.url in repr(view)
                view.close()
                del view
                os._exit(0)
            except BaseException:
                os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert np.array_equal(view.state, home)
        assert update(view)["status"] == "FREE"


def test_a_taken_port(arm):
    with arm.view() as view:
        port = int(view.url.rstrip("/").rsplit(":", 1)[1])
        with pytest.raises(cl.Error, match=str(port)):
            arm.view(port=port)
    arm.view(port=port).close()


def test_the_browser_is_opened(arm, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    with arm.view(open_browser=True) as view:
        assert opened == [view.url]
