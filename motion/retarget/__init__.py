"""Carries a motion over to another rig by the roles of its joints; builds on skeletons, roles and kinematics."""
