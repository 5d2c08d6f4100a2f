"""The database: tables, connections, migrations, its salt, and the answers while it is gone."""
