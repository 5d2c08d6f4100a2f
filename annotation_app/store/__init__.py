"""The database: tables, connections, migrations, its salt, and what is told when it is gone."""
