"""All sorts of sets, each with the function that makes one."""
import heads
import imu
import imu_camera
import outside
from boards import boards, videos
from flats import flats
from landmarks import landmarks
from motors import motors
from servos import servos
from sets import Plan, write
from walks import walks

SORTS = {"boards": boards, "videos": videos, "servos": servos, "motors": motors, "landmarks": landmarks, "walks": walks,
         "wheels": walks, "flats": flats}
# A sort that is made with an effect alone.
ALONE = {"heads": heads.heads, "imus": lambda plan: (imu_camera if plan.cause in imu_camera.EFFECTS else imu).imus(plan)}
# Causes that people have, each alone in the sets of a sort.
CAUSES = [f"{sort}+{cause}" for sort, causes in {
    "flats": ("dark_current_spread", "tap_gain", "periodic_pattern", "amplifier_glow", "noise_filter"),
    "boards": ("focal_drift", "focal_temperature", "flat_port", "view_motion", "focus_variation"), "videos": ("focal_drift",),
    "landmarks": ("mount_offset", "wall_excess", "landmark_delay", "landmark_height"),
    "motors": ("load_friction", "friction_asymmetry", "motor_heating", "elastic_joint", "torque_cogging"),
    "servos": ("gear_ripple", "elastic_joint"),
    "walks": ("tracker_offset", "turn_asymmetry", "tracker_turn"),
    "wheels": ("encoder_skew", "wheel_growth", "wheel_load"), "heads": heads.EFFECTS,
    "imus": (*imu.EFFECTS, *imu_camera.EFFECTS)}.items() for cause in causes]
# Causes outside the catalogue, each alone in the sets of a sort.
OUTSIDE = outside.sorts()


def make(sort, number):
    plan = Plan(sort, number)
    return plan, (SORTS | ALONE)[plan.base](plan)


def make_into(out, sort, number):
    plan, made = make(sort, number)
    return write(made, plan, out)
