"""Controllers, one file each: parameters, state, design and step."""
