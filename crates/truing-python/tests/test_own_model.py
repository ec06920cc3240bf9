"""Models that are written in Python."""

import numpy as np
import pytest
import truing
from truing import Effect, Model, Parameter


class Thermometer(Model):
    """Readings at known temperatures; the declared model is a zero error."""

    unit = "mK"
    base = [Parameter("zero", "mK")]
    effects = [
        Effect("gain", "the gain is off", [Parameter("gain", "%", 100.0)]),
        Effect("warm", "it warms with its current", [Parameter("warming", "mK/mA")], driver="current_ma"),
    ]

    def __init__(self, reference, read, current, std=None, check=()):
        self.reference, self.read, self.current = reference, read, current
        self.observations = [f"r{i}" for i in range(len(read))]
        self.std, self.check = std, check

    def residuals(self, base, amplitudes):
        [zero], [[gain], [warming]] = base, amplitudes
        return self.read - zero - self.reference * (1.0 + gain) - warming * self.current


@pytest.fixture
def data():
    draws = np.random.default_rng(77)
    reference, current = draws.uniform(-500.0, 500.0, 60), draws.uniform(0.0, 5.0, 60)
    return reference, reference + 3.0 + 2.0 * current + draws.normal(0.0, 0.5, 60), current


def test_what_was_hidden_is_named_with_its_size(data):
    reference, read, current = data
    closure = truing.close_loop(Thermometer(reference, read, current, std=0.5), {"current_ma": current})
    assert closure.verdict == "explained" and [s.effect for s in closure.steps] == ["warm"]
    size = closure.steps[0].parameters[0]
    assert abs(size.value - 2.0) < 4.0 * size.std and size.unit == "mK/mA"
    assert closure.after.held_out_rms < 0.5 * closure.before.held_out_rms
    assert closure.after.hold_out == "nested" and closure.residuals_after.shape == (60,)
    assert abs(closure.base[0] - 3.0) < 0.5 and closure.covariance.shape == (2, 2)
    assert "warm" in closure._repr_html_() and "explained" in closure._repr_html_()


@pytest.mark.parametrize("start", [[], [0.0, 1.0]])
def test_a_start_of_the_wrong_length_is_an_error(data, start):
    model = Thermometer(*data, std=0.5)
    model.start = start
    with pytest.raises(truing.InputError, match="`start` .* one value per base parameter"):
        truing.close_loop(model)


def test_groups_that_are_only_judged_are_never_fitted(data):
    reference, read, current = data
    judged = [f"r{i}" for i in range(40, 60)]
    spoiled = read.copy()
    spoiled[40:] += 1e3
    closure = truing.close_loop(Thermometer(reference, spoiled, current, std=0.5, check=judged))
    assert closure.before.hold_out == "check-groups"
    assert abs(closure.base[0] - 3.0) < 2.0


def test_nothing_is_named_where_nothing_is_missing(data):
    reference, _, current = data
    read = reference + 3.0 + np.random.default_rng(5).normal(0.0, 0.5, 60)
    closure = truing.close_loop(Thermometer(reference, read, current, std=0.5))
    assert closure.verdict == "nothing-missing" and closure.steps == []


def test_exceptions_of_the_model_come_through(data):
    class Broken(Thermometer):
        def residuals(self, base, amplitudes):
            raise ZeroDivisionError("in the model")

    with pytest.raises(ZeroDivisionError, match="in the model"):
        truing.close_loop(Broken(*data))


def test_models_that_contradict_themselves_are_refused(data):
    class Short(Thermometer):
        def residuals(self, base, amplitudes):
            return super().residuals(base, amplitudes)[:-1]

    with pytest.raises(truing.InputError, match="residuals must have the shape 60"):
        truing.close_loop(Short(*data))
    model = Thermometer(*data)
    model.groups = ["one"]
    with pytest.raises(truing.InputError, match="one for each of 60"):
        truing.close_loop(model)
    with pytest.raises(truing.InputError, match="which is no group"):
        truing.close_loop(Thermometer(*data, check=["r99"]))
    with pytest.raises(truing.InputError, match="std"):
        truing.close_loop(Thermometer(*data, std=np.ones(3)))

    class Twice(Thermometer):
        base = [Parameter("zero", "mK"), Parameter("zero again", "mK")]

        def residuals(self, base, amplitudes):
            return super().residuals(base[:1] + base[1:], amplitudes)

    with pytest.raises(truing.NotDeterminedError) as caught:
        truing.close_loop(Twice(*data))
    assert "zero" in caught.value.free_direction


def test_vectors_count_once(data):
    class Points(Model):
        unit = "mm"
        components = 3
        std = 0.01
        base = [Parameter(name, "mm") for name in ("x", "y", "z")]
        observations = [f"p{i}" for i in range(20)]

        def __init__(self):
            self.read = np.random.default_rng(9).normal(0.0, 0.01, (20, 3)) + [1.0, 2.0, 3.0]

        def residuals(self, base, amplitudes):
            return self.read - base

    closure = truing.close_loop(Points())
    assert np.allclose(closure.base, [1.0, 2.0, 3.0], atol=0.01)
    assert abs(closure.before.train_rms - 0.01 * np.sqrt(3.0)) < 0.005
