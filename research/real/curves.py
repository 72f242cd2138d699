"""Published curves from motor commands (PWM) and battery voltage to the inputs of models.

- Speed: Bitcraze measured 0.2685 PWM + 4070.3 turns per minute (bitcraze.io, "Measuring propeller
  RPM: part 3", 2015); the shipped map `nanobench` has it, and RotorPy's parameters cite it.
- Share of thrust: the firmware divides a table's voltage by the battery's to get the PWM
  (`motorsCompensateBatteryVoltage` in `motors.c`; coefficients below). Its inverse gives the thrust
  that the onboard controller asked for. Crazyflow's `pwm2force` takes that share.
"""

from __future__ import annotations

import numpy as np

from research.real.recorded_flights import MOST_PWM, Reals

SPEED = (426.24, 0.028117)  # [rad/s], of PWM
VOLTS = (0.088, -0.0006239)  # [V], of the thrust of four rotors in grams, linear and quadratic
MOST_GRAMS = 60.0  # of the firmware's thrust command 65536


def speed(pwm: Reals) -> Reals:
    """Rotor speeds [rad/s]; the voltage is not part of this curve."""
    return np.where(pwm > 0.0, SPEED[0] + SPEED[1] * np.clip(pwm, 0.0, MOST_PWM), 0.0)


def share(pwm: Reals, voltage: Reals) -> Reals:
    """Shares of the greatest thrust that the onboard controller asked of each rotor.

    Args:
        pwm: (..., rotors).
        voltage: of the battery [V], (...).
    """
    linear, quadratic = VOLTS
    volts = np.clip(pwm, 0.0, MOST_PWM) / MOST_PWM * voltage[..., None]
    root = np.sqrt(np.clip(linear**2 + 4.0 * quadratic * volts, 0.0, None))
    return np.clip((root - linear) / (2.0 * quadratic) / MOST_GRAMS, 0.0, 1.0)
