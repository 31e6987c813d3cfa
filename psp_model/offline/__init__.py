"""The offline half: global optima, data sets, training, and networks judged by what they cost on the road."""
