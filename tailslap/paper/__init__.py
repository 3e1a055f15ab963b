"""The command `paper`: what Chuong and Malla (2025) print, computed beside printed."""
