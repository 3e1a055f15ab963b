"""Whole impacts: scenes with [contact], from first touch on, by the rigid vehicle and by the FE plate.

`plan` solves the rigid vehicle, `fe_plan` makes the plate's model, `run` runs it and sets it beside the rigid one;
`answers` is what both are read for: strikes, filtered forces, occupant risk. `checks` judges a run. What is said of
them is in `rigid_text`, `check_text`, `summary` and `report`.
"""
