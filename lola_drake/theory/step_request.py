"""What a step's plan depends on, as a record and as the vector that a block can hold as state."""

from dataclasses import dataclass

import numpy as np

HORIZON = 3
"""Steps planned ahead; as on LOLA (interface headers, 2018)."""

REQUEST_SIZE = 29 + 4 * HORIZON
"""Numbers in a packed request."""


@dataclass(frozen=True)
class StepRequest:
    """Everything a step's plan depends on.

    Attributes:
        start_time: when the step begins (s).
        step_index: number of steps begun so far.
        swing: the foot that swings next, 0 left or 1 right.
        load: the left foot's share of the load at the start; 0.5 when standing.
        com, com_velocity: the plan's CoM at the start in P (m, m/s), shape (3,).
        feet: TCP poses x, y, z, yaw in P, left and right, each of shape (4,).
        path: the robot's frame on the ground x, y (m), yaw (rad).
        ground: height in P from which the coming steps go up (m).
        heading: the torso's yaw at the start (rad).
        support: duration of the double support that begins the step (s).
        blend: b_f of the left and right foot at the start, shape (2,).
        displacements: (forward, left, turn, up) of the coming steps, shape (n, 4); none to stand.
        wait: how long the load stays where it is before it moves (s).
        lift: by how much the feet are let down against the plan already (m).
    """

    start_time: float
    step_index: int
    swing: int
    load: float
    com: np.ndarray
    com_velocity: np.ndarray
    feet: tuple[np.ndarray, np.ndarray]
    path: np.ndarray
    ground: float
    heading: float
    support: float
    blend: np.ndarray
    displacements: np.ndarray
    wait: float = 0.0
    lift: float = 0.0


def pack_request(request: StepRequest) -> np.ndarray:
    """Return the request as a vector of fixed size."""
    displacements = np.zeros((HORIZON, 4))
    displacements[: len(request.displacements)] = request.displacements
    return np.concatenate(
        [
            [request.start_time, request.step_index, request.swing, request.load],
            request.com,
            request.com_velocity,
            *request.feet,
            request.path,
            [request.ground, request.heading, request.support, request.wait, request.lift],
            request.blend,
            [len(request.displacements)],
            displacements.ravel(),
        ]
    )


def unpack_request(vector: np.ndarray) -> StepRequest:
    """Return the request that `pack_request` wrote."""
    start_time, step_index, swing, load = vector[:4].tolist()
    com, com_velocity, left, right, path, pace, blend, count, displacements = np.split(
        vector[4:].copy(), np.cumsum([3, 3, 4, 4, 3, 5, 2, 1])
    )
    ground, heading, support, wait, lift = pace.tolist()
    return StepRequest(
        start_time=start_time,
        step_index=int(step_index),
        swing=int(swing),
        load=load,
        com=com,
        com_velocity=com_velocity,
        feet=(left, right),
        path=path,
        ground=ground,
        heading=heading,
        support=support,
        blend=blend,
        displacements=displacements.reshape(-1, 4)[: int(count[0])],
        wait=wait,
        lift=lift,
    )
