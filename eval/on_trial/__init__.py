"""Rules and features on trial: what each wins and loses, corpus by corpus."""
