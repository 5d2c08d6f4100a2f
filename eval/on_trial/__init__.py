"""Ablations: what each rule and feature set wins and loses, corpus by corpus."""
