"""Pictures of one moment, drawn without a screen: cameras, drawing into arrays, shadows, edges."""
