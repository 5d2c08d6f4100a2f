"""Identity of people: logins, sign-in, sessions."""
