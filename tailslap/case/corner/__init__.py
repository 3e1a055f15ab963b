"""The paper's method: Stages 1 to 3 of the rigid body, and the FE plate whose corner is held on the wall."""
