def check(kernel): pass
