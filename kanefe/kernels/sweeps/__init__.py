"""Sweeps of the order-n equations over a tree: outward for motion, inward for inertia and forces, outward for du."""
