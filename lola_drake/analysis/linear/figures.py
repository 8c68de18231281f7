"""Pictures of the analyses: Bode, poles and zeros, step responses, root locus."""

import warnings

import control
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lola_drake.analysis.linear.analyses import Analysis, Locus, step_response
from lola_drake.analysis.linear.frequency import LOWEST, Response, frequency_response
