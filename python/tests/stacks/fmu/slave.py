"""An emergency brake of two variables, for pythonfmu."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class PyAeb(Fmi2Slave):
    """It brakes with the whole pedal within a distance."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.speed, self.gap, self.pedal = 0.0, 200.0, 0.0
        self.register_variable(Real("speed", causality=Fmi2Causality.input))
        self.register_variable(Real("gap", causality=Fmi2Causality.input))
        self.register_variable(Real("pedal", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        print("a step of Python")
        wanted = 1.0 if self.gap < 2.0 + self.speed**2 / 10.0 else 0.0
        self.pedal += 0.5 * (wanted - self.pedal)
        return True
