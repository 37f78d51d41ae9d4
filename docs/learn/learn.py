#!/usr/bin/python3
"""Learns to turn the head until the ball is in the middle of the picture: Q-learning with numpy alone.

Usage: learn.py [--episodes 40] [--seed 1] [--out curve.csv]
"""
import argparse
import pathlib

import numpy as np
import seam_gym
import seam_sdk

TURNS_RAD = np.array([-0.8, -0.4, -0.2, 0, 0.2, 0.4, 0.8])  # By which the head turns: the actions.
MOST_RAD = 1.2
COLUMNS, PLACES = 7, 7  # States: where the ball is in the picture, or else where the head looks.
REWARD = ("abs(atan2(truth.ball.y_m - truth.r0.y_m, truth.ball.x_m - truth.r0.x_m) - truth.r0.heading_rad - truth.r0.pan_rad)"
          " < 0.15")


def turn_head(action, seen):
    return seam_sdk.Decision().joints({"pan": np.clip(seen.sensors.joints.pan_rad + TURNS_RAD[action], -MOST_RAD, MOST_RAD)})


def column_of_ball(seen, frame):
    """The column of the picture in which the orange pixels are, or COLUMNS."""
    if frame is None:
        return COLUMNS
    red, green, blue = np.moveaxis(frame.rgb_array().astype(int), 2, 0)
    columns = np.nonzero((red > 60) & (red > 2 * green) & (red > 4 * blue))[1]
    return int(columns.mean() * COLUMNS / frame.width_px) if len(columns) > 3 else COLUMNS


def state_of(observation):
    if observation["ball"] < COLUMNS:
        return int(observation["ball"])
    return COLUMNS + int(np.clip((observation["joints"][1] / MOST_RAD + 1) / 2 * PLACES, 0, PLACES - 1))


def episode(env, values, random, seed, tries):
    """Plays and learns; the mean reward. `tries`: the share of turns at random."""
    angle = random.uniform(-MOST_RAD, MOST_RAD)
    place = {"ball.x_m": 0.8 * np.cos(angle), "ball.y_m": 0.8 * np.sin(angle)}
    observation, _ = env.reset(seed=seed, options={"set": place})
    state, rewards, over = state_of(observation), [], False
    while not over:
        action = int(random.integers(len(TURNS_RAD)) if random.random() < tries else values[state].argmax())
        observation, reward, _, over, _ = env.step(action)
        after = state_of(observation)
        values[state, action] += 0.5 * (reward + 0.8 * values[after].max() - values[state, action])
        state = after
        rewards.append(reward)
    return np.mean(rewards)


def learn(episodes, seed):
    """Yields the mean reward of each episode."""
    here, random = pathlib.Path(__file__).parent, np.random.default_rng(seed)
    # Values start at the highest that they can have, so that each action is tried.
    values = np.full((COLUMNS + PLACES, len(TURNS_RAD)), 5.0)
    ball = seam_gym.Sense("ball", seam_gym.Discrete(COLUMNS + 1), column_of_ball)
    act = seam_gym.Act(seam_gym.Discrete(len(TURNS_RAD)), turn_head)
    with seam_gym.Env(here / "ball.yaml", observe=["joints", ball], act=act, reward=REWARD) as env:
        for number in range(episodes):
            yield episode(env, values, random, seed + number, 0.1 * 0.96 ** number)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="curve.csv")
    given = parser.parse_args()
    curve = []
    with open(given.out, "w", buffering=1) as out:
        out.write("episode,in_sight,mean_of_10\n")
        for value in learn(given.episodes, given.seed):
            curve.append(value)
            out.write(f"{len(curve)},{value:.3f},{np.mean(curve[-10:]):.3f}\n")
    print(f"the ball is in sight in {np.mean(curve[:10]):.0%} of the turns of the first 10 episodes, {np.mean(curve[-10:]):.0%} of the last 10")


if __name__ == "__main__":
    main()
