"""Linear models of any discrete diagram; studies of LOLA and their presentation beside them."""
