"""What uncertainties are owed to beside the inputs, by name; read without what computes means."""

LAW = "law"  # what it does not explain of a run, as an input that its fits share
