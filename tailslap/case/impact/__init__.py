"""The whole impact of a scene with [contact], by the rigid vehicle and by the FE plate."""
