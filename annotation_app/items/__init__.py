"""What people work on: who has which item, answers kept once, and what videos show."""
