"""Estimate a body's sizes from several keyframes: a suggestion, which can be undone."""

from keypose.tracker.fitting.sizes.proposals import Proposal
from keypose.tracker.fitting.sizes.sizes import SizesFitted, fit_sizes

__all__ = ["Proposal", "SizesFitted", "fit_sizes"]
