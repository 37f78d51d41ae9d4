"""Formulas of effects that are more than a line, written here from their sources and not from SEAM: what
`scripts/effect_proofs.py` computes worked examples with."""
import math


def root(f, low, high):
    """Where f changes its sign, by halving."""
    for _ in range(200):
        middle = (low + high) / 2
        if (f(low) < 0) == (f(middle) < 0):
            low = middle
        else:
            high = middle
    return (low + high) / 2


def play(width, *motor):
    """A load in a gap: it stays until the motor has crossed the gap."""
    load = motor[0]
    for q in motor:
        load = min(max(load, q - width / 2), q + width / 2)
    return load


def turned(roll, pitch, yaw, x, y, z):
    """Rz(yaw) Ry(pitch) Rx(roll) of a point whose camera looks along the link's x axis."""
    x, y, z = z, -x, -y
    y, z = math.cos(roll) * y - math.sin(roll) * z, math.sin(roll) * y + math.cos(roll) * z
    x, z = math.cos(pitch) * x + math.sin(pitch) * z, -math.sin(pitch) * x + math.cos(pitch) * z
    x, y = math.cos(yaw) * x - math.sin(yaw) * y, math.sin(yaw) * x + math.cos(yaw) * y
    return x, y, z


def spun(vector, x, y, z):
    """A point turned by the length of the vector about its direction, by quaternions."""
    angle = math.sqrt(sum(part * part for part in vector))
    w, i, j, k = math.cos(angle / 2), *(math.sin(angle / 2) * part / angle for part in vector)

    def times(a, b):
        return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])
    return times(times((w, i, j, k), (0, x, y, z)), (w, -i, -j, -k))[1:]


def vibrating(line_hz, width_hz, skew, at_hz, rate_hz, folds=3000):
    """Power of samples of an oscillator that white noise drives, of its deflection and its rate by `skew`, folded at the rate
    again and again, and what is left of it beyond."""
    own_2 = line_hz ** 2 + width_hz ** 2 / 4  # Damped it swings at line_hz.

    def density(f):
        swung = ((1 + skew) / 2 * own_2 + (1 - skew) / 2 * f * f) * width_hz / math.pi
        return swung / ((own_2 - f * f) ** 2 + (f * width_hz) ** 2)
    near = sum(density(at_hz + k * rate_hz) for k in range(-folds, folds + 1))
    return rate_hz * near + (1 - skew) * width_hz / math.pi / rate_hz / (folds + 0.5)


def walked(p, legs, scale=lambda p, v: v, steps=400000):
    """Small steps of a walk: legs of ((vx, vy, omega), seconds), without lag."""
    x = y = theta = 0.0
    for command, seconds in legs:
        vx, vy, omega = scale(p, command)
        h = seconds / steps
        for _ in range(steps):
            middle = theta + omega * h / 2
            x += h * (vx * math.cos(middle) - vy * math.sin(middle))
            y += h * (vx * math.sin(middle) + vy * math.cos(middle))
            theta += omega * h
    return x, y, theta


def beside(p, v):
    """Velocity of a point (p[0], p[1]) off the axle."""
    return v[0] - p[1] * v[2], v[1] + p[0] * v[2], v[2]


def rolled(legs, left=lambda w, v, omega: w, right=lambda w, v, omega: w):
    """Wheels 0.2 m apart: legs of ((left, right) in m/s, seconds); a wheel's true speed by its own, v and omega."""
    def body(p, speeds):
        v, omega = (speeds[0] + speeds[1]) / 2, (speeds[1] - speeds[0]) / 0.2
        a, b = left(speeds[0], v, omega), right(speeds[1], v, omega)
        return (a + b) / 2, 0, (b - a) / 0.2
    return walked(None, legs, body)


def elastic(p, drive, rate, at_s, steps=40000):
    """A load on a spring behind a drive whose angle and rate are functions of time, in small steps."""
    omega = 2 * math.pi / p[0]
    def acceleration(t, q, w):
        return omega ** 2 * (drive(t) - q) + 2 * p[1] * omega * (rate(t) - w)
    q = w = 0.0
    h = at_s / steps
    for k in range(steps):
        t = k * h
        a1 = acceleration(t, q, w)
        a2 = acceleration(t + h / 2, q + h / 2 * w, w + h / 2 * a1)
        a3 = acceleration(t + h / 2, q + h / 2 * (w + h / 2 * a1), w + h / 2 * a2)
        a4 = acceleration(t + h, q + h * (w + h / 2 * a2), w + h * a3)
        q += h * w + h * h / 6 * (a1 + a2 + a3)
        w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q


def swung(at_s, stall=200, back_emf=10, gain=0.5, damping=0, most=1, limit=math.inf, gravity=0, level=0, viscous=0,
          coulomb=0, stribeck=0, slow=1, load=0, pull=0, cogging=0, waves=1, phase=0, command=1, steps=40000):
    """A motor's joint from rest at 0, in small steps of Runge and Kutta; where it does not come to rest on its way."""
    def acceleration(q, w):
        duty = min(max(gain * (command - q) - damping * w, -most), most)
        net = min(max(stall * duty - back_emf * w, -limit), limit) - gravity * math.cos(q - level) - pull
        net += cogging * math.sin(waves * q + phase)
        way = w if w != 0 else net
        dry = coulomb + stribeck * math.exp(-abs(w) / slow) + load * abs(net)
        return net - viscous * w - math.copysign(dry, way)
    q = w = 0.0
    h = at_s / steps
    for _ in range(steps):
        a1 = acceleration(q, w)
        a2 = acceleration(q + h / 2 * w, w + h / 2 * a1)
        a3 = acceleration(q + h / 2 * (w + h / 2 * a1), w + h / 2 * a2)
        a4 = acceleration(q + h * (w + h / 2 * a2), w + h * a3)
        q += h * w + h * h / 6 * (a1 + a2 + a3)
        w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q


def sprung(stiffness, damping, way, t):
    """A linear spring with damping, let go at rest, from 0 to this way."""
    omega = math.sqrt(stiffness - damping * damping / 4)
    left = math.exp(-damping / 2 * t) * (math.cos(omega * t) + damping / 2 / omega * math.sin(omega * t))
    return way * (1 - left)


def driven(stiffness, damping, t):
    """What drives that spring from 0 to 1: its acceleration."""
    omega = math.sqrt(stiffness - damping * damping / 4)
    rate = stiffness / omega * math.exp(-damping / 2 * t) * math.sin(omega * t)
    return stiffness * (1 - sprung(stiffness, damping, 1, t)) - damping * rate


def fisheye(p, x, y, z):
    """r_d over the tangent's r of a ray."""
    t = math.atan2(math.hypot(x, y), z)
    return t * (1 + sum(k * t ** (2 * i + 2) for i, k in enumerate(p))) / math.hypot(x, y)


def spline_lens(p, x, y, z):
    """Of a ray: stereographic, by its angle, and moved by B-splines, by the recursion of Cox and de Boor over the knots."""
    angle, way = math.atan2(math.hypot(x, y), z), math.atan2(y, x)
    u = [2 * math.tan(angle / 2) * math.cos(way), 2 * math.tan(angle / 2) * math.sin(way)]
    apart = 4 * math.tan(math.radians(p[0]) / 4) / 5  # From one control point to the next.

    def bump(i, degree, at):
        """Over knots at whole numbers, from i on."""
        if degree == 0:
            return 1.0 if i <= at < i + 1 else 0.0
        return ((at - i) * bump(i, degree - 1, at) + (i + degree + 1 - at) * bump(i + 1, degree - 1, at)) / degree
    values, moved = iter(p[1:]), list(u)
    for row in range(6):
        for column in range(8):
            for part in (0, 1):
                moved[part] += (next(values) * bump(column - 2, 3, u[0] / apart + 3.5) * bump(row - 2, 3, u[1] / apart + 2.5))
    return moved


def through_port(p, x, y, z):
    """The tangent of a point's ray in air, over the point's radius: by halving, from Snell's law in angles."""
    r = math.hypot(x, y)
    def meets(angle):
        pane, beyond = math.asin(math.sin(angle) / 1.49), math.asin(math.sin(angle) / p[0])
        return p[1] * math.tan(angle) + p[2] * math.tan(pane) + (z - p[1] - p[2]) * math.tan(beyond)
    return math.tan(root(lambda angle: meets(angle) - r, 0, 1.5)) / r


def slid(p, x, y, z):
    """Depth of a point from the pupil that its ray enters by."""
    r = math.hypot(x, y)
    return z - p[0] * (math.atan2(r, z) * math.hypot(r, z) / r - 1)


def tangential(p, x, y):
    r2 = x * x + y * y
    return (x + 2 * p[0] * x * y + p[1] * (r2 + 2 * x * x),
            y + p[0] * (r2 + 2 * y * y) + 2 * p[1] * x * y)


def rational(p, r2):
    return (1 + p[0] * r2 + p[1] * r2**2 + p[2] * r2**3) / (1 + p[3] * r2 + p[4] * r2**2 + p[5] * r2**3)
