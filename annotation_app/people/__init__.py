"""Who somebody is: people, logins, sign-in, sessions."""
